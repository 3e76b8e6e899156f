"""The paper's robot in MuJoCo: a chain of links on ball joints, tendons through sites. No line of tendond is in it.

A clamped rod of length L is N ball joints at (i + 1/2) L/N with rigid links between them. A joint stands for L/N of
rod: its stiffness is EI N/L, its damping Bbt N/L (moment = EI u + Bbt u_t). Torsion is as stiff as bending. Tendons
pass the links parallel to the backbone through two sites each, a quarter of a link from its ends. The tip carries a
body of its own, which may be heavy. Drag is quadratic, in the links' own axes: minus C q |q| for each metre, applied to
the links' centres.
"""

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SITE_GAP = 0.25
"""Distance g of a tendon's sites from the joint, as a part of a link h. A bend of a joint shortens a tendon of radius r
by r + g h / 2 times the bend per radian, nearly; from 2 g h / r on (0.42 rad) the sites would pass each other."""

STEEL = 7850.0
"""[kg/m^3] Of the sphere that a tip mass is."""

SLACK = 10.0
"""[m] Length to which a tendon's winch is let out when it is not to pull."""


class DivergedError(Exception):
    """The integrator has no solution any more."""


@dataclass(frozen=True)
class Robot:
    """Parameters; the defaults are the paper's robot.

    Attributes:
        length: of the backbone [m]. radius: of its section [m].
        youngs_modulus: [Pa]. density: [kg/m^3]. damping: Bbt, of bending [N m^2 s]. drag: C, of each axis [kg/m^2].
        gravity: world frame, the straight robot along +z [m/s^2].
        tendons: (x, y) of each in the section [m]. stiffness: of a wound tendon [N/m].
        tip_mass: of the body on the tip [kg].
        links: ball joints. step: of the integrator [s].
    """

    length: float = 0.5
    radius: float = 1e-3
    youngs_modulus: float = 190e9
    density: float = 17189.0
    damping: float = 0.008
    drag: float = 0.1
    gravity: tuple[float, float, float] = (-9.81, 0.0, 0.0)
    tendons: tuple[tuple[float, float], ...] = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))
    stiffness: float = 2e4
    tip_mass: float = 0.0
    links: int = 30
    step: float = 1e-3

    @property
    def bending_stiffness(self) -> float:
        """EI [N m^2]."""
        return self.youngs_modulus * math.pi * self.radius**4 / 4.0

    @property
    def mass_per_length(self) -> float:
        """[kg/m]"""
        return self.density * math.pi * self.radius**2


def sphere(mass: float) -> tuple[float, float]:
    """Radius [m] and moment of inertia [kg m^2] of a steel sphere of `mass` [kg]."""
    radius = (3.0 * mass / (4.0 * math.pi * STEEL)) ** (1.0 / 3.0)
    return radius, 0.4 * mass * radius**2


def _quiet(_: str) -> None:
    """Keep MuJoCo from writing a file of warnings: `advance` raises instead."""


mujoco.set_mju_user_warning(_quiet)


class MujocoRobot:
    """The robot at rest under gravity, slack; then wherever tensions or winches take it.

    Args:
        robot: parameters.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.model = mujoco.MjModel.from_xml_string(_mjcf(robot))
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
        self.let_go()
        self.settle()

    def attach(self, mass: float) -> None:
        """Set the mass of the body on the tip to `mass` [kg]."""
        self.model.body_mass[self._tip_body] = mass
        self.model.body_inertia[self._tip_body] = sphere(mass)[1]
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    def let_go(self) -> None:
        """Torque off: no tendon pulls."""
        self._wound = False
        self.data.ctrl[: self._count] = 0.0
        self.data.ctrl[self._count :] = SLACK

    def pull(self, tension: Array) -> None:
        """Pull the tendons with `tension` [N], shape (n,); less than zero is zero."""
        self.let_go()
        self.data.ctrl[: self._count] = np.maximum(tension, 0.0)

    def wind(self, displacement: Array) -> None:
        """Wind the tendons' ends to `displacement` [m], shape (n,), from the straight robot; they are elastic."""
        self._wound = True
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
        """Come to rest, with more damping than the robot has, for `duration` [s] at most.

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
        """Push the tip with a dead force [N], world frame, shape (3,), until told otherwise."""
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
        """Displacements of the tendons' ends from straight [m], shape (n,): as commanded, or as the shape has it."""
        if self._wound:
            return np.array(self._straight - self.data.ctrl[self._count :])
        return np.array(self._straight - self.data.ten_length)

    def _apply_drag(self) -> None:
        speed = self.data.sensordata.reshape(-1, 3)  # of the links' centres, in the links' axes
        force = -self._drag * speed * np.abs(speed)
        axes = self.data.xmat[self._links].reshape(-1, 3, 3)
        self.data.xfrc_applied[self._links, :3] = np.einsum("kij,kj->ki", axes, force)


def _mjcf(robot: Robot) -> str:
    """The robot as MuJoCo reads it."""
    h = robot.length / robot.links
    section = robot.density * math.pi * robot.radius**4 / 4.0
    names: list[list[str]] = [[] for _ in robot.tendons]

    def sites(link: str, heights: tuple[float, ...]) -> str:
        text = ""
        for tendon, (x, y) in enumerate(robot.tendons):
            for end, z in enumerate(heights):
                name = f"{link}_t{tendon}_{end}"
                names[tendon].append(name)
                text += f'<site name="{name}" pos="{x} {y} {z!r}"/>'
        return text

    chain = sites("base", (0.0, h / 2.0 - SITE_GAP * h))
    for i in range(robot.links):
        last = i == robot.links - 1
        length = h / 2.0 if last else h
        mass = robot.mass_per_length * length
        bend = mass * length**2 / 12.0 + section * length
        place = h / 2.0 if i == 0 else h
        chain += (
            f'<body name="link{i}" pos="0 0 {place!r}"><joint type="ball" stiffness="{robot.bending_stiffness / h!r}" '
            f'damping="{robot.damping / h!r}"/>'
            f'<inertial pos="0 0 {length / 2.0!r}" mass="{mass!r}" diaginertia="{bend!r} {bend!r} '
            f'{2.0 * section * length!r}"/><site name="centre{i}" pos="0 0 {length / 2.0!r}"/>'
        )
        chain += sites(f"link{i}", (SITE_GAP * h, length if last else length - SITE_GAP * h))
    chain += f'<body name="tip_mass" pos="0 0 {h / 2.0!r}"><inertial pos="0 0 0" mass="1e-12" '
    chain += 'diaginertia="1e-18 1e-18 1e-18"/><site name="tip"/></body>' + "</body>" * robot.links
    strings = "".join(
        f'<spatial name="t{tendon}">' + "".join(f'<site site="{name}"/>' for name in through) + "</spatial>"
        for tendon, through in enumerate(names)
    )
    motors = "".join(f'<motor tendon="t{tendon}" gear="-1"/>' for tendon in range(len(names)))
    winches = "".join(
        f'<position tendon="t{tendon}" kp="{robot.stiffness!r}" forcelimited="true" forcerange="-10000 0"/>'
        for tendon in range(len(names))
    )
    speeds = "".join(f'<velocimeter site="centre{i}"/>' for i in range(robot.links))
    x, y, z = robot.gravity
    return (
        f'<mujoco><compiler angle="radian"/><option timestep="{robot.step!r}" integrator="implicitfast" '
        f'gravity="{x!r} {y!r} {z!r}"><flag contact="disable" constraint="disable" '
        f'autoreset="disable"/></option>'
        f"<worldbody>{chain}</worldbody><tendon>{strings}</tendon><actuator>{motors}{winches}</actuator>"
        f"<sensor>{speeds}</sensor></mujoco>"
    )
