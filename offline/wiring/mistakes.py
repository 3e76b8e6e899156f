"""The mistakes: what each makes of poses, commands and reports between a right plant and its controller."""

import itertools
import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rotations import rotation_matrix, turn_by
from tendond.drivers.simulator.lockstep import Wires
from tendond.model.numerics.rotation import quaternion
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import TendonCommand, TendonState, TipPose

Array = NDArray[np.float64]
Change = Callable[[Array, Array], tuple[Array, Array]]
"""A change of position [m] and rotation."""

AXES = "xyz"
OLD_SECONDS = (0.1, 0.2, 0.3, 0.5)


@dataclass(frozen=True)
class Mistake:
    """One thing wrong.

    Attributes:
        group: row of the table. name: within it.
        wires: created for each run, since some keep a history.
    """

    group: str
    name: str
    wires: Callable[[], Wires]


def all_mistakes(config: RigConfig) -> list[Mistake]:
    """List every mistake of the study, for a rig."""
    count = len(config.rod.tendon_positions)
    return [*_frames(), *_bases(config.rod.length), *_scales(), *_quaternions(), *_others(config), *_old(config),
            *_tendons(count)]  # fmt: skip


def with_poses(change: Change) -> Callable[[], Wires]:
    """Wires on which each pose is changed."""

    def pose(_: int, pose: TipPose | None) -> TipPose | None:
        if pose is None:
            return None
        position, rotation = change(np.array(pose.position), rotation_matrix(pose.orientation))
        x, y, z = position.tolist()
        return pose.model_copy(update={"position": (x, y, z), "orientation": quaternion(rotation)})

    return lambda: Wires(pose=pose)


def _turned(turn: Array) -> Change:
    return lambda position, rotation: (turn @ position, turn @ rotation)


def _displaced(offset: Array) -> Change:
    return lambda position, rotation: (position + offset, rotation)


def _scaled(scale: float) -> Change:
    return lambda position, rotation: (scale * position, rotation)


def _reordered(order: Sequence[int]) -> Callable[[], Wires]:
    """Wires on which the components of each quaternion are in another order."""

    def pose(_: int, pose: TipPose | None) -> TipPose | None:
        if pose is None:
            return None
        w, x, y, z = (pose.orientation[index] for index in order)
        return pose.model_copy(update={"orientation": (w, x, y, z)})

    return lambda: Wires(pose=pose)


def _resting_at(position: Array) -> Callable[[int], Array]:
    return lambda tick: position


def _frames() -> Iterator[Mistake]:
    """Axes swapped, mirrored, turned; once with the orientation turned as well, once with it left alone."""

    def both(group: str, name: str, matrix: Array) -> Iterator[Mistake]:
        yield Mistake(group, name, with_poses(lambda p, r: (matrix @ p, matrix @ r @ matrix.T)))
        yield Mistake(group, f"{name}, orientation as it was", with_poses(lambda p, r: (matrix @ p, r)))

    for order in itertools.permutations(range(3)):
        if order != (0, 1, 2):
            name = "measured (x, y, z) = true (" + ", ".join(AXES[axis] for axis in order) + ")"
            yield from both("axes swapped", name, np.eye(3)[list(order)])
    for signs in itertools.product((1.0, -1.0), repeat=3):
        if min(signs) < 0.0 and np.prod(signs) < 0.0:
            name = " and ".join(axis for axis, sign in zip(AXES, signs, strict=True) if sign < 0.0)
            yield from both("axes mirrored", f"{name} mirrored", np.diag(signs))
    for axis, angle in itertools.product(range(3), (10.0, -10.0, 90.0, -90.0, 180.0)):
        turn = turn_by(math.radians(angle) * np.eye(3)[axis])
        group = f"frame rotated by {abs(angle):.0f} degrees"
        yield Mistake(group, f"{angle:.0f} about {AXES[axis]}", with_poses(_turned(turn)))


def _bases(length: float) -> Iterator[Mistake]:
    for axis, part in itertools.product(range(3), (0.04, -0.04, 0.1, -0.1)):
        offset = part * length * np.eye(3)[axis]
        name = f"{part * length * 1e3:+.0f} mm along {AXES[axis]}"
        group = f"base off by {abs(part) * 100:.0f} % of the length"
        yield Mistake(group, name, with_poses(_displaced(offset)))


def _scales() -> Iterator[Mistake]:
    for scale in (0.9, 1.1, 0.01, 1000.0):
        group = "lengths 0.9 or 1.1 of the true" if scale in (0.9, 1.1) else "lengths in another unit"
        yield Mistake(group, f"times {scale:g}", with_poses(_scaled(scale)))


def _quaternions() -> Iterator[Mistake]:
    orders = {"x y z w": (1, 2, 3, 0), "z y x w": (3, 2, 1, 0)}
    for name, order in orders.items():
        yield Mistake("quaternion in another order", name, _reordered(order))


def _others(config: RigConfig) -> Iterator[Mistake]:
    """Poses that are not this arm's: of another robot, or of an arm that is held."""
    length = config.rod.length
    still: dict[str, tuple[str, Array, Array]] = {}
    for part in (0.6, 0.8, 1.25):
        rod = rod_from_section(config.rod.model_copy(update={"length": part * length}), config.loop.period)
        tip = rod.tip(rod.solve_static(np.zeros(rod.parameters.tendon_count)))
        still[f"{part:g} times as long"] = ("another robot, resting", tip.position, tip.rotation)
    rod = rod_from_section(config.rod, config.loop.period)
    still["beside it"] = ("another robot, resting", np.array([0.6 * length, 0.2 * length, 0.9 * length]), np.eye(3))
    still["straight"] = ("an arm left straight, sagging, or bent", np.array([0.0, 0.0, length]), np.eye(3))
    for name, tension, weight in (("bent by a tendon", 5.0, 0.0), ("sagging under 300 g", 0.0, 0.3)):
        pulled = np.zeros(rod.parameters.tendon_count)
        pulled[0] = tension
        tip = rod.tip(rod.solve_static(pulled, tip_force=weight * np.array(config.rod.gravity)))
        still[name] = ("an arm left straight, sagging, or bent", tip.position, tip.rotation)
    for name, (group, position, rotation) in still.items():
        yield Mistake(group, name, _elsewhere(_resting_at(position), rotation))
    tip = rod.tip(rod.solve_static(np.zeros(rod.parameters.tendon_count)))
    for frequency in (0.3, 1.0, 3.0):

        def swaying(tick: int, rate: float = 2.0 * math.pi * frequency * config.loop.period) -> Array:
            angle = rate * tick
            return np.asarray(tip.position) + 0.1 * length * np.array([math.sin(angle), math.cos(angle), 0.0])

        name = f"circling at {frequency:g} Hz"
        yield Mistake("another robot, moving", name, _elsewhere(swaying, tip.rotation))


def _elsewhere(place: Callable[[int], Array], rotation: Array) -> Callable[[], Wires]:
    """Poses from another place, with a tenth of a millimetre of noise."""
    random = np.random.default_rng(5)

    def pose(tick: int, pose: TipPose | None) -> TipPose | None:
        if pose is None:
            return None
        x, y, z = (place(tick) + 1e-4 * random.standard_normal(3)).tolist()
        return pose.model_copy(update={"position": (x, y, z), "orientation": quaternion(rotation)})

    return lambda: Wires(pose=pose)


def _old(config: RigConfig) -> Iterator[Mistake]:
    """Poses that have waited in a queue; their stamps are honest."""
    for seconds in OLD_SECONDS:
        cycles = round(seconds / config.loop.period)

        def wires(cycles: int = cycles) -> Wires:
            queue: deque[TipPose | None] = deque()

            def pose(_: int, pose: TipPose | None) -> TipPose | None:
                queue.append(pose)
                return queue.popleft() if len(queue) > cycles else None

            return Wires(pose=pose)

        yield Mistake("old poses", f"{seconds * 1e3:.0f} ms", wires)


def _tendons(count: int) -> Iterator[Mistake]:
    """Yield every order and sign of the tendons, and spools that are larger or smaller than configured."""
    for order in itertools.permutations(range(count)) if count <= 4 else _transpositions(count):
        for signs in itertools.product((1.0, -1.0), repeat=count):
            moved, reversed_ = order != tuple(range(count)), min(signs) < 0.0
            if not (moved or reversed_):
                continue
            group = (
                "tendons in another order and reversed" if moved and reversed_
                else "tendons in another order" if moved else "tendons reversed"
            )  # fmt: skip
            name = f"order {' '.join(map(str, order))}, signs {' '.join('+' if s > 0 else '-' for s in signs)}"
            yield Mistake(group, name, _connected(order, signs))
    for factor in (2.0, 0.5):
        for which in (*[(i,) for i in range(count)], tuple(range(count))):
            factors = tuple(factor if i in which else 1.0 for i in range(count))
            name = f"times {factor:g}, tendon{'s' if len(which) > 1 else ''} {' '.join(map(str, which))}"
            yield Mistake(f"spools times {factor:g}", name, _connected(tuple(range(count)), factors))


def _transpositions(count: int) -> Iterator[tuple[int, ...]]:
    """Yield the identity, every swap of two, and a rotation by one."""
    yield tuple(range(count))
    for i, j in itertools.combinations(range(count), 2):
        order = list(range(count))
        order[i], order[j] = j, i
        yield tuple(order)
    yield (*range(1, count), 0)


def _connected(order: tuple[int, ...], factors: tuple[float, ...]) -> Callable[[], Wires]:
    """Servo i pulls tendon order[i] by factors[i] of its command; it reports the command as done."""

    def command(command: TendonCommand) -> TendonCommand:
        displacement, tension = [0.0] * len(order), [0.0] * len(order)
        for servo, (tendon, factor) in enumerate(zip(order, factors, strict=True)):
            displacement[tendon] = factor * command.displacement[servo]
            tension[tendon] = max(0.0, factor * command.tension[servo])
        return command.model_copy(update={"displacement": tuple(displacement), "tension": tuple(tension)})

    def report(report: TendonState) -> TendonState:
        displacement = tuple(
            report.displacement[tendon] / factor for tendon, factor in zip(order, factors, strict=True)
        )
        tension = tuple(report.tension[tendon] for tendon in order)
        return report.model_copy(update={"displacement": displacement, "tension": tension})

    return lambda: Wires(command=command, report=report)
