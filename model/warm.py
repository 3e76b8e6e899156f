"""Load kernels from the cache, or compile them, in parts: `tendond warm` runs this module in child processes."""

import math
import sys
from collections.abc import Callable

import numpy as np

from tendond.model.body.ahead import look_ahead
from tendond.model.body.clearance import Kept, SurfaceRows, find_clearance
from tendond.model.body.points import PointWeights, find_points
from tendond.model.body.trajectory import Trajectory
from tendond.model.estimation.compliance import tip_compliance
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import noise_of
from tendond.model.estimation.observer import observe, start_observer
from tendond.model.estimation.observer_gains import ObserverGains
from tendond.model.numerics.announce import report_compilation
from tendond.model.numerics.compile import Bound
from tendond.model.numerics.nearest import nearest_allowed
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rod.trajectory import simulate_trajectory
from tendond.model.rods.general import GeneralRod
from tendond.model.strain import Robot, Section, StrainRod, Tendon
from tendond.model.strain.analysis.summary import summarise
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.kinematics import empty_shape
from tendond.model.tendons.allocation import Allocation

TENDONS = 4
"""Number of the paper's robot."""


def _rod(tendons: int) -> Rod:
    """Return a shooting rod with this number of tendons around it; its kernels are for up to 4, 8 or 16."""
    angles = 2.0 * math.pi * np.arange(tendons) / tendons
    positions = tuple((0.02 * math.cos(angle), 0.02 * math.sin(angle)) for angle in angles)
    return Rod(RodParameters(tendon_positions=positions), "euler", nodes=10)


def warm_up(tendons: int = TENDONS) -> None:
    """Run each kernel of the shooting rod once, as it is controlled; takes a second when they are cached."""
    rod = _rod(tendons)
    state = rod.step(rod.solve_static())
    rod.tip(state)
    rod.sensitivity(state)
    rod.predict(state, np.zeros(tendons), np.ones((2, tendons)), np.zeros(3))
    rod.velocity_jacobian(state, 0)
    tip = rod.tip(state).position
    gains = ObserverGains(
        kind="force",
        period=0.01,
        delay=0.0,
        integral=1.0,
        proportional=1.0,
        derivative=0.0,
        noise_floor=1.0,
        noise_share=1.0,
        innovation_time=1.0,
        force_max=1.0,
        offset_gain=1.0,
    )
    observe(gains, start_observer(gains, tip), rod, state, tip, tip)
    tip_compliance(rod, state)
    rod.solve_static(displacements=[0.0] * tendons)
    allocation = Allocation(rod.parameters.tendon_positions, 0.0, 1.0)
    allocation.tensions(allocation.nearest(np.zeros(2)))


def warm_up_trajectories(tendons: int = TENDONS) -> None:
    """Run the kernel of whole trajectories of the shooting rod, by which the identification simulates a log."""
    rod = _rod(tendons)
    simulate_trajectory(rod, rod.solve_static(), np.tile(rod.loads([0.0] * tendons), (2, 1)))


def warm_up_general(tendons: int = TENDONS) -> None:
    """Run the kernels of the general rod once, as `config check` looks at a robot, and as it is controlled.

    They depend on no number of tendons or sections.
    """
    wire, route = Section.round(0.5, 1e-3, 200e9, 7850.0), (0.02, 0.0)
    robot = Robot((wire,), (Tendon(0.5, route),))
    rod, model = StrainRod(robot), GeneralRod(robot, 0.01)
    rubbing = StrainRod(Robot((wire,), (Tendon(0.5, route, stiffness=2e4, friction=0.1),)))
    rubbing.step(rubbing.solve_static(rubbing.loads([1.0])), rubbing.loads([2.0]))
    summarise(rod, 1.0, modes=1)
    rod.energy(rod.step(rod.rest(), rod.loads()))
    model.tip(model.step(model.solve_static()))
    linear = Linearisation(rod)
    linear.outputs(linear.step(rod.rest(), rod.loads()).state)
    linear.tip(rod.rest(), rod.loads())
    linear.rest(rod.rest(), rod.loads())


def warm_up_filter(tendons: int = TENDONS) -> None:
    """Run the estimator's kernels once, on a tip that has been pushed away, so that its search weighs a contact."""
    wire, route = Section.round(0.5, 1e-3, 200e9, 7850.0), (0.02, 0.0)
    model = GeneralRod(Robot((wire,), (Tendon(0.5, route),)), 0.01)
    noise = noise_of(model.parameters, 1e-4, 2e-3, 0.1, 1.0, 0.1)
    estimator, state = Estimator(model, noise, contacts=noise), model.solve_static()
    estimate, (place, turn) = estimator.start(state), model.strain_rod.tip(state.strain)
    for cycle in range(10):
        ahead = estimator.step(estimate, state, np.zeros(len(model.robot.tendons)))
        estimate, state = estimator.advance(estimate, state, ahead), ahead
        pushed = place + np.array([0.0, 2e-3 * cycle, 0.0])
        estimate, state = estimator.correct(estimate, state, [Reading(0, 0.0, pushed, turn)])


def warm_up_body(tendons: int = TENDONS) -> None:
    """Run the kernels of the safety filter once: points of the body, their motion, clearances, the nearest command."""
    wire, route = Section.round(0.5, 1e-3, 200e9, 7850.0), (0.02, 0.0)
    model = GeneralRod(Robot((wire,), (Tendon(0.5, route),)), 0.01)
    rod, state = model.strain_rod, model.solve_static()
    weights, n = PointWeights(*model.backbone.weights(np.array([0.25, 0.5]))), rod.modes
    points, jacobians, loads = np.empty((2, 3)), np.empty((2, 3, n)), model.loads(None)
    Bound(find_points).call(rod.layout, state.strain.strain, empty_shape(rod.layout), weights, points, jacobians)
    Trajectory(rod, weights, 1e-6).follow(state.strain, loads, np.zeros((2, 1)))
    step, coming, bends = Linearisation(rod).step(state.strain, loads), np.zeros(2 * n), np.zeros((2, n))
    moves, turns = np.empty((2, 6, 2)), np.empty((2, 2, 2))
    Bound(look_ahead).call(step.a, step.b, coming, 0.5, 1, 1, 1, jacobians.reshape(-1, n), bends, moves, turns)
    rows = SurfaceRows(np.zeros(1, np.intp), np.ones((1, 3)), np.ones(1), np.empty((0, 3)), np.empty(0), np.empty(0))
    moved, found = (moves.reshape(2, 2, 3, 2), turns.reshape(2, 1, 2, 2)), (np.empty((2, 2)), np.empty((2, 1, 3)))
    Bound(find_clearance).call(
        rows, Kept(0.0, 0.0, 0.0, 1.0), points, np.zeros((1, 2)), *moved, np.ones(2), *found, np.empty((2, 1, 2)),
        np.empty(2),
    )  # fmt: skip
    Bound(nearest_allowed).call(np.ones((4, 1)), np.ones((2, 2)), *(np.ones(1) for _ in range(4)))


PARTS: dict[str, Callable[[int], None]] = {
    "shooting": warm_up,
    "trajectories": warm_up_trajectories,
    "general": warm_up_general,
    "filter": warm_up_filter,
    "body": warm_up_body,
}
"""Each takes the number of tendons. The second one calls kernels of the first, the others those of the third."""


if __name__ == "__main__":
    report_compilation(lambda name: print(name, flush=True))
    for part in sys.argv[2:]:
        PARTS[part](int(sys.argv[1]))
