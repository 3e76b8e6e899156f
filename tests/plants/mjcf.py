"""MJCF of the robot: a chain of links on ball joints, tendons through sites. No line of tendond is in it.

A clamped rod of length L is N ball joints at (i + 1/2) L/N with rigid links between them. A joint stands for L/N of
rod: its stiffness is EI N/L, its damping Bbt N/L (moment = EI u + Bbt u_t). Torsion is as stiff as bending. Tendons
pass the links parallel to the backbone through two sites each, a quarter of a link from its ends. The tip carries a
body of its own, which may be heavy.
"""

import math
from dataclasses import dataclass

SITE_GAP = 0.25
"""Distance g of a tendon's sites from the joint, as a part of a link h. A bend of a joint shortens a tendon of radius r
by r + g h / 2 times the bend per radian, nearly; from 2 g h / r on (0.42 rad) the sites would pass each other."""


@dataclass(frozen=True)
class Robot:
    """Parameters of the robot; the defaults are the paper's.

    Attributes:
        length: length of the backbone [m]. radius: radius of its section [m].
        youngs_modulus: [Pa]. density: [kg/m^3]. damping: Bbt of bending [N m^2 s]. drag: C of each axis [kg/m^2].
        gravity: world frame, the straight robot along +z [m/s^2].
        tendons: (x, y) of each in the section [m]. stiffness: stiffness of a tendon on a winch [N/m].
        tip_mass: mass of the body on the tip [kg].
        links: number of ball joints. step: time step of the integrator [s].
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
        """Mass per length [kg/m]."""
        return self.density * math.pi * self.radius**2


def mjcf(robot: Robot) -> str:
    """Return the robot as MuJoCo reads it."""
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
