"""The paper's robot in MuJoCo, driven by tensions or by winches. No line of tendond is in it.

Drag is quadratic, in the links' own axes: minus C q |q| for each metre, applied to the links' centres.
"""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from tests.plants.mjcf import Robot, mjcf

Array = NDArray[np.float64]

STEEL = 7850.0
"""Density of the sphere that stands for a tip mass [kg/m^3]."""

SLACK = 10.0
"""Length of a tendon that does not pull, beyond any that the shape needs [m]."""


class DivergedError(Exception):
    """The integrator has no solution any more."""


def sphere(mass: float) -> tuple[float, float]:
    """Radius [m] and moment of inertia [kg m^2] of a steel sphere of `mass` [kg]."""
    radius = (3.0 * mass / (4.0 * math.pi * STEEL)) ** (1.0 / 3.0)
    return radius, 0.4 * mass * radius**2


def _ignore_warning(_: str) -> None:
    """Keep MuJoCo from writing a file of warnings: `advance` raises instead."""


mujoco.set_mju_user_warning(_ignore_warning)


class MujocoRobot:
    """Robot, at rest under gravity and slack until it is driven.

    Args:
        robot: parameters.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.model = mujoco.MjModel.from_xml_string(mjcf(robot))
        self.data = mujoco.MjData(self.model)
        self._count = len(robot.tendons)
        self._tip_body = self.model.body("tip_mass").id
        self._tip_site = self.model.site("tip").id
        self._links = np.array([self.model.body(f"link{i}").id for i in range(robot.links)])
        lengths = np.full(robot.links, robot.length / robot.links)
        lengths[-1] /= 2.0
        self._drag = robot.drag * lengths[:, None]
        self._straight = self.model.tendon_length0.copy()
        self.attach(robot.tip_mass)
        self.release()
        self.settle()

    def attach(self, mass: float) -> None:
        """Set the mass of the body on the tip to `mass` [kg]."""
        self.model.body_mass[self._tip_body] = mass
        self.model.body_inertia[self._tip_body] = sphere(mass)[1]
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def release(self) -> None:
        """Switch the torque off: no tendon pulls."""
        self._by_displacement = False
        self.data.ctrl[: self._count] = 0.0
        self.data.ctrl[self._count :] = SLACK

    def set_tension(self, tension: Array) -> None:
        """Pull the tendons with `tension` [N], shape (n,); negative values are zero."""
        self.release()
        self.data.ctrl[: self._count] = np.maximum(tension, 0.0)

    def set_displacement(self, displacement: Array) -> None:
        """Place the tendons' ends at `displacement` [m], shape (n,), from straight; the tendons are elastic."""
        self._by_displacement = True
        self.data.ctrl[: self._count] = 0.0
        self.data.ctrl[self._count :] = self._straight - displacement

    def advance(self, duration: float) -> None:
        """Simulate `duration` [s], a whole number of steps.

        Raises:
            DivergedError: the integrator has no solution any more.
        """
        for _ in range(round(duration / self.robot.step)):
            if self.robot.drag:
                self._apply_drag()
            mujoco.mj_step(self.model, self.data)
            if self.data.warning.number.any():
                raise DivergedError(f"the plant has diverged at {self.data.time:.3f} s")
        mujoco.mj_forward(self.model, self.data)

    def settle(self, duration: float = 20.0, speed: float = 1e-7) -> None:
        """Come to rest, with more damping than the robot has, for up to `duration` [s].

        Args:
            duration: [s].
            speed: of the joints below which the robot rests [rad/s].
        """
        kept = self.model.dof_damping.copy()
        self.model.dof_damping[:] = max(3.0 * self.robot.damping, 0.01) * self.robot.links / self.robot.length
        for _ in range(round(duration / 0.05)):
            self.advance(50 * 1e-3)
            if float(np.abs(self.data.qvel).max()) < speed:
                break
        self.model.dof_damping[:] = kept
        self.data.qvel[:] = 0.0
        self.data.time = 0.0
        mujoco.mj_forward(self.model, self.data)

    def push(self, force: Array) -> None:
        """Push the tip with a dead force [N], world frame, shape (3,), until the next call."""
        self.data.xfrc_applied[self._tip_body, :3] = force

    @property
    def position(self) -> Array:
        """Position of the tip [m], world frame, shape (3,)."""
        return np.array(self.data.site_xpos[self._tip_site])

    @property
    def rotation(self) -> Array:
        """Rotation of the tip, body to world, shape (3, 3); its third column is the direction of the rod."""
        return np.array(self.data.site_xmat[self._tip_site]).reshape(3, 3)

    @property
    def quaternion(self) -> Array:
        """Orientation of the tip, w, x, y, z, shape (4,)."""
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, self.data.site_xmat[self._tip_site])
        return quaternion

    @property
    def tension(self) -> Array:
        """Tensions of the tendons [N], shape (n,)."""
        force = self.data.actuator_force
        return np.array(force[: self._count] - force[self._count :])

    @property
    def displacement(self) -> Array:
        """Displacements of the tendons' ends from straight [m], shape (n,): commanded, or that of the shape."""
        if self._by_displacement:
            return np.array(self._straight - self.data.ctrl[self._count :])
        return np.array(self._straight - self.data.ten_length)

    def _apply_drag(self) -> None:
        speed = self.data.sensordata.reshape(-1, 3)  # of the links' centres, in the links' axes
        force = -self._drag * speed * np.abs(speed)
        axes = self.data.xmat[self._links].reshape(-1, 3, 3)
        self.data.xfrc_applied[self._links, :3] = np.einsum("kij,kj->ki", axes, force)
