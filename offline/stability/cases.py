"""The cases of the map: a robot, a rate, a delay, a damping, an error of E and a bend."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond import TendondError
from tendond.daemon.control.laws import BENDING_PLANE, LAWS, StatefulLaw
from tendond.daemon.control.pose.task import PoseTask, least_tension
from tendond.daemon.control.reference.planar import PLANES, in_world
from tendond.model.errors import ConvergenceError
from tendond.model.rod.static_curve import StaticCurve, static_curve
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.selection import model_rod
from tendond.offline.robustness.unlike import unlike
from tendond.offline.stability.loop import Linear, Loop
from tendond.schemas.config.rig import RigConfig, check_config

Array = NDArray[np.float64]

RATES = (50.0, 100.0, 250.0, 500.0)
TOLERANCE = 1e-3
"""Error of a radius: fast modes of a scheme without numerical damping lie on the unit circle, and a step's tolerance
moves them by up to 3e-4 (nitinol at 100 Hz, in a run of 600 cycles neither growing nor falling)."""

SETTLE = 400
"""Cycles for which a loop that pulls all tendons runs before it is differenced."""

MISSING = 1e-3
"""Largest change of a state in a cycle that counts as an equilibrium, in the scales of its parts."""

BENDS = (20.0, 60.0, 100.0)
"""Bends of the model at the target [degrees]."""


@dataclass(frozen=True)
class Case:
    """A point of the map.

    Attributes:
        robot: preset. law: name; none: the one that the robot has by default.
        rate: of the loop [Hz]. delay: of the poses, as configured [cycles].
        damping: factor on the robot's [-]. stiffness: E of the plant over that of the model [-].
        bend: of the model at the target [degrees].
    """

    robot: str
    law: str | None = None
    rate: float = 100.0
    delay: int = 0
    damping: float = 1.0
    stiffness: float = 1.0
    bend: float = 60.0


@dataclass(frozen=True)
class Result:
    """What a case comes to.

    Attributes:
        case: as given. law: of the loop. tension: of the agonist at the equilibrium [N].
        radius: largest modulus of an eigenvalue of the loop [-]; inf where there is no equilibrium.
        decay: of the slowest motion [1/s]; negative: it grows. frequency: of that motion [Hz].
        missing: of the equilibrium [-], see `Linear`.
    """

    case: Case
    law: str
    tension: float
    radius: float
    decay: float
    frequency: float
    missing: float

    @property
    def stable(self) -> bool:
        """True if all motions about an equilibrium decay, but for what the differences leave open."""
        return self.radius < 1.0 + TOLERANCE and self.missing < MISSING


def configured(case: Case) -> RigConfig:
    """Return the configuration of a case, without its reference; both rods are general ones."""
    period = 1.0 / case.rate
    data = {
        "rod": {"preset": case.robot},
        "loop": {"period": period},
        "control": {"solver": "general"} | ({} if case.law is None else {"law": case.law}),
        "observer": {"delay": case.delay * period},
        "commissioning": {"rest": False, "probe": False},
        "simulator": {"period": period, "solver": "general"},
    }
    config = check_config(data, str(case))
    if case.damping != 1.0:
        values = config.model_dump(mode="json")
        values["rod"] = _damped(values["rod"], case.damping)
        values["simulator"]["rod"] = values["rod"]
        config = check_config(values, str(case))
    if case.stiffness != 1.0:
        values = config.model_dump(mode="json")
        values["simulator"]["rod"] = unlike(config.rod, case.stiffness).model_dump(mode="json")
        config = check_config(values, str(case))
    return config


def _damped(rod: dict[str, object], factor: float) -> dict[str, object]:
    """Multiply a robot's damping."""
    changed = dict(rod)
    ratio, given = rod.get("damping_ratio"), rod.get("bending_damping")
    if isinstance(ratio, float):
        changed["damping_ratio"] = factor * ratio
    elif isinstance(given, list | tuple):
        changed["bending_damping"] = [factor * float(one) for one in given]
    return changed


def solve(case: Case) -> Result:
    """Compute the eigenvalues of a case; without an equilibrium they are infinite.

    Raises:
        TendondError: the law has a state of its own, which the loop's does not have.
    """
    law = configured(case).control.law
    if isinstance(LAWS.get(law), StatefulLaw):
        raise TendondError(f"law '{law}': its own state is not among the loop's: choose a law without one")
    return solve_loop(configured(case), case)


def solve_loop(config: RigConfig, case: Case) -> Result:
    """Compute the eigenvalues of a configuration at the bend of a case, with poses as late as there; see `solve`."""
    try:
        return _result(case, loop_of(config, case).linear(), config)
    except ConvergenceError:
        return Result(case, config.control.law, math.nan, math.inf, -math.inf, 0.0, math.inf)


def looped(case: Case) -> tuple[Loop, RigConfig]:
    """Return the loop of a case at its resting target, and its configuration."""
    config = configured(case)
    return loop_of(config, case), config


def loop_of(config: RigConfig, case: Case) -> Loop:
    """Return the loop of a configuration at a resting target, bent as in a case, with poses as late as there."""
    rod = model_rod(config)
    assert isinstance(rod, GeneralRod)
    tension, place = held(config, rod, math.radians(case.bend))
    values = config.model_dump(mode="json")
    values["limits"]["tension_max"] = min(500.0, 3.0 * float(tension.max()) + 1.0)
    values["reference"] = {"kind": "step", "position": place, "unreachable": "track", "path": "direct"}
    if LAWS[config.control.law].task_space is not BENDING_PLANE:  # it pulls all tendons, and reaches no place along
        tension = tension + least_tension(config)
        across = {**values, "reference": {"kind": "step", "across": place[0], "unreachable": "track"}}
        loop = Loop(check_config(across, str(case)), tension, case.delay)
        task = loop.setup.selection.task
        if not isinstance(task, PoseTask) or task.counts != "across":  # folded: the reference would go on moving
            loop = Loop(check_config(values, str(case)), tension, case.delay)
        loop.settle(SETTLE)
        return loop
    return Loop(check_config(values, str(case)), tension, case.delay)


def _result(case: Case, found: Linear, config: RigConfig) -> Result:
    first = found.eigenvalues[0]
    decay, frequency = -math.log(max(found.radius, 1e-12)) * case.rate, abs(float(np.angle(first))) * case.rate
    tension = float(found.tension[config.control.agonist])
    return Result(case, config.control.law, tension, found.radius, decay, frequency / (2.0 * math.pi), found.missing)


def held(config: RigConfig, rod: GeneralRod, bend: float) -> tuple[Array, tuple[float, float, float]]:
    """Return the tensions [N], shape (n,), that hold the model bent by an angle [rad], and its tip then [m]."""
    curve, axes = curve_to(config, rod, bend), PLANES[config.control.plane]
    arc = float(curve.where_angle(bend)[0])
    tension = np.zeros(rod.parameters.tendon_count)
    tension[config.control.agonist] = curve.tension_at(arc)
    state = rod.solve_static(np.zeros(len(tension)))
    for part in np.linspace(0.0, 1.0, 9)[1:]:
        state = rod.solve_static(part * tension, start=state)
    x, z = rod.tip(state).position[list(axes)].tolist()
    return tension, in_world((x, z), axes)


def curve_to(config: RigConfig, rod: GeneralRod, bend: float) -> StaticCurve:
    """Return the curve of resting tips at least up to a bend [rad], with no more tension than that needs."""
    one, axes = rod.parameters, PLANES[config.control.plane]
    arm = abs(one.tendon_positions[config.control.agonist][0 if axes[0] == 0 else 1])
    most = one.bending_stiffness * bend / (arm * one.length)
    for _ in range(8):
        curve = static_curve(rod, config.control.agonist, most, axes)
        if curve.angle[-1] > bend:
            return curve
        most *= 1.6
    return curve


def map_cases(robots: tuple[str, ...], law: str | None, *, short: bool = False) -> list[Case]:
    """List the map: each robot at each rate and bend; then one property at a time at the middle bend."""
    rates, bends = (RATES[1:2], BENDS[1:2]) if short else (RATES, BENDS)
    found: list[Case] = []
    for robot in robots:
        found += [Case(robot, law, rate=rate, bend=bend) for rate in rates for bend in bends]
        if short:
            continue
        middle = Case(robot, law)
        for rate in RATES[:3]:
            here = replace(middle, rate=rate)
            found += [replace(here, delay=delay) for delay in (1, 2)]
            found += [replace(here, damping=damping) for damping in (0.1, 0.01)]
            found += [replace(here, stiffness=stiffness) for stiffness in (0.85, 1.15)]
    return found
