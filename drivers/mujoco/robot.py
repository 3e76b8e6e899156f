"""A chain in MuJoCo, driven by tensions or by winches.

Drag is quadratic, in the links' own axes: minus C q |q| for each metre, applied to the links' centres.
"""

import mujoco
import numpy as np
from numpy.typing import NDArray

from tendond.drivers.mujoco.chain import Chain
from tendond.drivers.mujoco.mjcf import mjcf

Array = NDArray[np.float64]

SLACK = 10.0
"""Length of a tendon that does not pull, beyond any that the shape needs [m]."""

ROTATION = 1e-5
"""Rotation of a joint by which a tendon's lever arm is found by differences [rad]."""


class DivergedError(Exception):
    """The integrator has no solution any more."""


def _ignore_warning(_: str) -> None:
    """Keep MuJoCo from writing a file of warnings: `advance` raises instead."""


mujoco.set_mju_user_warning(_ignore_warning)


class MujocoRobot:
    """Robot, straight and slack until it is driven or settles.

    Args:
        chain: description.

    Attributes:
        chain: as given. model, data: of MuJoCo.
    """

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        self.model = mujoco.MjModel.from_xml_string(mjcf(chain))
        self.data = mujoco.MjData(self.model)
        self._count = len(chain.tendons)
        self._tip_body = self.model.body("tip_mass").id
        self._tip_site = self.model.site("tip").id
        self._links = np.array([self.model.body(f"link{i}").id for i in range(len(chain.links))])
        self._drag = np.array([np.array(one.drag) * chain.reach(i) for i, one in enumerate(chain.links)])
        self._dragged = bool(self._drag.any())
        self._straight = self.model.tendon_length0.copy()
        self._pushes = np.zeros((len(chain.links), 3))
        self.attach(0.0, 0.0)
        self.release()

    def attach(self, mass: float, inertia: float) -> None:
        """Set mass [kg] and moment of inertia about every axis [kg m^2] of the load on the tip."""
        self.model.body_mass[self._tip_body] = mass
        self.model.body_inertia[self._tip_body] = inertia
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
        for _ in range(round(duration / self.model.opt.timestep)):
            self._apply_forces()
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
        self.model.dof_damping[:] = np.maximum(3.0 * kept, self.model.jnt_stiffness[self.model.dof_jntid] / 15.0)
        for _ in range(round(duration / 0.05)):
            self.advance(0.05)
            if float(np.abs(self.data.qvel).max()) < speed:
                break
        self.model.dof_damping[:] = kept
        self.data.qvel[:] = 0.0
        self.data.time = 0.0
        mujoco.mj_forward(self.model, self.data)

    def push(self, force: Array) -> None:
        """Push the tip with a dead force [N], world frame, shape (3,), until the next call."""
        self.data.xfrc_applied[self._tip_body, :3] = force

    def push_links(self, forces: Array) -> None:
        """Push the links' centres with dead forces [N], world frame, shape (links, 3), until the next call."""
        self._pushes = forces

    def place(self, positions: Array, rates: Array) -> None:
        """Put the joints at a configuration and its rates, MuJoCo's qpos and qvel."""
        self.data.qpos[:], self.data.qvel[:] = positions, rates
        mujoco.mj_forward(self.model, self.data)

    def inertance(self) -> Array:
        """Return the inverse of the mass matrix at present, by the joints' rates, shape (dofs, dofs)."""
        found = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_forward(self.model, self.data)
        mujoco.mj_solveM(self.model, self.data, found, np.eye(self.model.nv))
        return found

    def tendon_arms(self) -> Array:
        """Return the derivative of the tendons' lengths by the joints' rotations at present [m], shape (n, dofs)."""
        data, found = mujoco.MjData(self.model), np.zeros((self._count, self.model.nv))
        for dof in range(self.model.nv):
            change = np.zeros(self.model.nv)
            for side in (-1.0, 1.0):
                change[dof] = side * ROTATION
                data.qpos[:] = self.data.qpos
                mujoco.mj_integratePos(self.model, data.qpos, change, 1.0)
                mujoco.mj_fwdPosition(self.model, data)
                found[:, dof] += side * data.ten_length / (2.0 * ROTATION)
        return found

    @property
    def position(self) -> Array:
        """Position of the tip [m], world frame, shape (3,)."""
        return np.array(self.data.site_xpos[self._tip_site])

    @property
    def rotation(self) -> Array:
        """Rotation of the tip, body to world, shape (3, 3); its third column is the direction of the rod."""
        return np.array(self.data.site_xmat[self._tip_site]).reshape(3, 3)

    @property
    def rate(self) -> Array:
        """Angular rate of the tip, then its velocity, world frame [rad/s, m/s], shape (6,)."""
        found = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_SITE, self._tip_site, found, 0)
        return found

    @property
    def quaternion(self) -> Array:
        """Orientation of the tip, w, x, y, z, shape (4,)."""
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, self.data.site_xmat[self._tip_site])
        return quaternion

    @property
    def joints(self) -> Array:
        """Positions of the base, the joints and the tip [m], world frame, shape (links + 2, 3)."""
        return np.vstack((np.zeros(3), self.data.xpos[self._links], self.data.site_xpos[self._tip_site]))

    @property
    def link_rotations(self) -> Array:
        """Rotations of the links, body to world, shape (links, 3, 3)."""
        return np.array(self.data.xmat[self._links]).reshape(-1, 3, 3)

    @property
    def tension(self) -> Array:
        """Tensions of the tendons [N], shape (n,)."""
        force = self.data.actuator_force
        return np.array(force[: self._count] - force[self._count :])

    @property
    def shortening(self) -> Array:
        """Shortening of the tendons' paths by the shape, from straight [m], shape (n,)."""
        return np.array(self._straight - self.data.ten_length)

    @property
    def displacement(self) -> Array:
        """Displacements of the tendons' ends from straight [m], shape (n,): commanded, or that of the shape."""
        if self._by_displacement:
            return np.array(self._straight - self.data.ctrl[self._count :])
        return self.shortening

    def _apply_forces(self) -> None:
        """Push the links: drag, and what `push_links` asks for."""
        force = self._pushes
        if self._dragged:
            speed = self.data.sensordata.reshape(-1, 3)  # of the links' centres, in the links' axes
            axes = self.data.xmat[self._links].reshape(-1, 3, 3)
            force = force + np.einsum("kij,kj->ki", axes, -self._drag * speed * np.abs(speed))
        self.data.xfrc_applied[self._links, :3] = force
