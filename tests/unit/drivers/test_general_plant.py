"""The general rod as the simulated plant: as the shooting rod where both solve, and where only it does."""

from collections.abc import Iterator

import numpy as np
import pytest

from tendond.drivers.simulator.lockstep import open_loop, watched_loop
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import GeneralPlantRod, plant_rod
from tendond.model.errors import ConvergenceError
from tendond.schemas.assumed_rig import TENDON_STIFFNESS
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.requests import ControlAction

LENGTH = 0.5
FRICTION = 0.2


def rig(**simulator: object) -> RigConfig:
    return check_config({"simulator": simulator}, "test")


def pulls(tensions: tuple[float, ...], cycles: int) -> Iterator[TendonCommand]:
    for seq in range(cycles):
        nothing = (0.0,) * len(tensions)
        yield TendonCommand(seq=seq, stamp_ns=0, pose_seq=None, displacement=nothing, tension=tensions, armed=True)


def test_the_papers_run_is_the_same_on_both_plants() -> None:
    """The controller's model is the shooting rod: on the general plant it still ends on its reference."""
    runs = [list(watched_loop(rig(solver=solver), 400, {5: ControlAction.ARM})) for solver in ("shooting", "general")]
    tips = [np.array([watched.truth.position for watched in run]) for run in runs]
    assert runs[1][-1].record.mode is Mode.TRACKING
    apart = np.linalg.norm(tips[1] - tips[0], axis=1)
    assert apart[100:].max() < 0.003 * LENGTH
    assert apart.max() < 0.08 * LENGTH  # while it moves, as the shooting rod takes its loads half a step late
    assert tips[1][-1][0] == pytest.approx(0.34, abs=2e-4)


@pytest.mark.parametrize("tension", [5.0, 30.0])
def test_a_wire_that_hardly_damps_is_simulated_where_shooting_finds_no_solution(tension: float) -> None:
    robot = {"bending_damping": [1e-6, 1e-6, 1e-6], "drag": [0.0, 0.0, 0.0]}
    command = (tension, 0.0, 0.0, 0.0)
    with pytest.raises(ConvergenceError):
        list(open_loop(rig(rod=robot, solver="shooting", period=0.001), pulls(command, 300)))
    truths = [truth for _, truth in open_loop(rig(rod=robot, solver="general", period=0.001), pulls(command, 300))]
    tips = np.array([truth.position for truth in truths])
    assert np.all(np.isfinite(tips))
    assert np.linalg.norm(tips, axis=1).max() <= 1.001 * LENGTH
    assert tips[:, 0].max() > 0.05  # it moves


def test_a_weight_hangs_as_low_from_both_and_swings_with_them() -> None:
    plants = []
    for solver in ("shooting", "general"):
        config = rig(solver=solver, weight={"mass": 0.02})
        plants.append(Plant(config, plant_rod(config.simulator, 0.01)))
    tips = [np.array(plant.observe(0)[2].position) for plant in plants]
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-4 * LENGTH
    assert tips[0][0] < -0.08  # 20 g more than its own weight


def test_a_weight_that_is_hung_up_in_the_middle_of_a_motion_counts_from_then_on_and_may_be_taken_off() -> None:
    config = rig(solver="general")
    rod, fresh = plant_rod(config.simulator, 0.01), plant_rod(config.simulator, 0.01)
    tensions = np.array([8.0, 0.0, 0.0, 0.0])
    state = rod.solve_static(np.zeros(4))
    for _ in range(10):
        state = rod.step(state, tensions)
    assert np.linalg.norm(rod.tip(state).velocity) > 0.1
    moving = state
    rod.load_tip(0.03)
    fresh.load_tip(0.03)
    state = rod.step(moving, tensions)
    assert rod.tip(state).position.tolist() == fresh.tip(fresh.step(moving, tensions)).position.tolist()
    for _ in range(500):
        state = rod.step(state, tensions)
    heavy = rod.tip(state).position
    assert heavy == pytest.approx(fresh.tip(fresh.solve_static(tensions)).position, abs=1e-5)
    rod.load_tip(0.0)
    for _ in range(500):
        state = rod.step(state, tensions)
    light = rod.tip(state).position
    assert light == pytest.approx(plant_rod(config.simulator, 0.01).tip(rod.solve_static(tensions)).position, abs=1e-5)
    assert light[0] > heavy[0] + 0.02  # gravity is along -x


def test_a_tendon_bends_the_sections_that_it_passes_and_no_others() -> None:
    config = check_config({"rod": {"preset": "franka-tdcr-v4"}}, "test")
    rod = plant_rod(config.simulator, 0.01)
    assert isinstance(rod, GeneralPlantRod)
    for tendon, passed in ((0, 0.06), (3, 0.1225), (6, 0.1865)):
        tension = np.zeros(9)
        tension[tendon] = 3.0
        points = rod.curve(rod.solve_static(tension), 374)  # 0.5 mm apart
        tangents = np.diff(points, axis=0)
        tangents /= np.linalg.norm(tangents, axis=1)[:, None]
        at = np.linspace(0.0, 0.1865, 374)[1:]
        beyond = tangents[at > passed + 0.008]  # chords of the nodes
        assert float(np.arccos(np.clip(tangents[0] @ tangents[-1], -1.0, 1.0))) > 0.3
        if len(beyond):
            assert np.abs(beyond - beyond[-1]).max() < 1e-6


def test_elastic_tendons_pull_with_their_stretch_and_a_push_is_whole() -> None:
    config = rig(solver="general", drive="displacement", rod={"tendon_stiffness": 5e3})
    rod = plant_rod(config.simulator, 0.01)
    start = rod.solve_static(np.zeros(4))
    ends = np.array([0.01, 0.0, -0.01, 0.0])
    state = start
    for _ in range(300):
        state = rod.step(state, displacements=ends)
    assert state.tensions == pytest.approx(np.maximum(0.0, 5e3 * (ends - rod.displacements(state))), abs=1e-9)
    assert rod.displacements(state, elastic=True)[0] == pytest.approx(0.01, abs=1e-9)
    for place in (0.03, 0.5, 0.97):
        rod.spread_push(place)
        assert isinstance(rod, GeneralPlantRod)
        assert rod._push.sum() == pytest.approx(1.0)
        assert np.all(rod._push >= 0.0)


def test_a_robot_that_shooting_cannot_describe_is_refused_where_it_is_asked_for() -> None:
    from tendond.model.errors import ParameterError

    config = check_config({"rod": {"preset": "rao-2021"}, "simulator": {"solver": "shooting"}}, "test")
    with pytest.raises(ParameterError, match="section"):
        plant_rod(config.simulator, 0.01)


def test_a_model_that_rubs_commands_the_displacements_of_a_plant_that_rubs_and_does_not_chatter() -> None:
    tendons = {"tendon_stiffness": TENDON_STIFFNESS, "tendon_friction": FRICTION}
    errors = []
    for friction in (0.0, FRICTION):
        config = check_config(
            {
                "rod": {**tendons, "tendon_friction": friction},
                "control": {"solver": "general"},
                "simulator": {"solver": "general", "drive": "displacement", "rod": tendons},
            },
            "test",
        )
        run = list(watched_loop(config, 250, {5: ControlAction.ARM}))
        assert run[-1].record.mode is Mode.TRACKING
        errors.append(max(abs(watched.truth.position[0] - 0.34) for watched in run[200:]))
        commands = np.array([watched.record.command.displacement for watched in run[200:]])
    assert errors[1] < 2e-5
    assert errors[1] < 0.02 * errors[0]
    assert np.abs(np.diff(commands, axis=0)).max() < 1e-6


def driven(period: float, friction: float, drive: str) -> np.ndarray:
    """Tips [m] each 10 ms, shape (40, 3), of a plant whose servos follow a moving goal, new each 10 ms."""
    config = rig(
        solver="general",
        drive="displacement",
        period=period,
        servo={"rate": 0.2, "acceleration": 1.5, "lag": 0.03, "friction": friction},
        rod={"tendon_stiffness": TENDON_STIFFNESS},
    )
    config = config.model_copy(update={"simulator": config.simulator.model_copy(update={"drive": drive})})
    count, tips = round(0.01 / period), []
    goals = 0.02 * (1.0 - np.cos(np.pi * np.arange(40) / 20.0))
    commands = (
        TendonCommand(
            seq=0,
            stamp_ns=0,
            pose_seq=None,
            displacement=(goal, -goal, -goal, -goal),
            tension=(500.0 * goal, 0.0, 0.0, 0.0),
            armed=True,
        )
        for goal in goals.tolist()
        for _ in range(count)
    )
    for index, (_, truth) in enumerate(open_loop(config, commands), 1):
        if index % count == 0:
            tips.append(truth.position)
    return np.array(tips)


@pytest.mark.parametrize("drive", ["displacement", "tension"])
def test_servos_that_move_drive_the_plant_as_in_short_steps_to_second_order(drive: str) -> None:
    fine = driven(0.00125, 0.0, drive)
    coarse, half = (driven(period, 0.0, drive) for period in (0.01, 0.005))
    errors = [float(np.sqrt(np.mean((tips - fine) ** 2))) for tips in (coarse, half)]
    assert errors[0] > 2.8 * errors[1] or drive == "tension"  # whose commands jump
    speed = np.gradient(fine, 0.01, axis=0)
    late = float(np.sum(speed * (fine - coarse)) / np.sum(speed**2))
    assert abs(late) < 5e-4  # a goal that is held over the step is early by half of 10 ms


def test_tendons_that_rub_take_their_ends_at_the_end_of_a_step() -> None:
    fine, coarse = driven(0.00125, FRICTION, "displacement"), driven(0.01, FRICTION, "displacement")
    speed = np.gradient(fine, 0.01, axis=0)
    assert abs(float(np.sum(speed * (fine - coarse)) / np.sum(speed**2))) < 1e-3
