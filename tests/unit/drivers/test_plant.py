"""The simulated servos, motion capture and loads do what their sections say."""

import math

import numpy as np
import pytest

from tendond.drivers.simulator.faults import Faults
from tendond.drivers.simulator.mocap import Mocap
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.servo import SimulatedActuators
from tendond.model import Rod, RodParameters
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import parse_config
from tendond.schemas.config.simulator import SimulatedMocap, SimulatedServos
from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.messages import TendonCommand

ROD = Rod(RodParameters())
REST = ROD.tip(ROD.solve_static(np.zeros(4)))
PERIOD = 0.01


def servo_displacements(section: SimulatedServos, goals: list[float]) -> list[float]:
    servos = SimulatedActuators(section, PERIOD, np.zeros(1))
    return [float(servos.follow_displacement(np.array([goal]), np.zeros(1))[1][0]) for goal in goals]


def test_ideal_servos_are_at_their_goals() -> None:
    assert servo_displacements(SimulatedServos(), [0.01, -0.02]) == pytest.approx([0.01, -0.02])


def test_a_servo_keeps_its_rate_and_acceleration_and_arrives_without_overshoot() -> None:
    trajectory = np.array(servo_displacements(SimulatedServos(rate=0.1, acceleration=2.0), [0.02] * 100))
    speed = np.diff(trajectory, prepend=0.0) / PERIOD
    assert speed.max() == pytest.approx(0.1)
    assert np.abs(np.diff(speed, prepend=0.0)).max() <= 2.0 * PERIOD + 1e-9
    assert trajectory.max() <= 0.02 + 1e-9
    assert trajectory[-1] == pytest.approx(0.02, abs=1e-6)


def test_a_lag_has_its_time_constant() -> None:
    trajectory = servo_displacements(SimulatedServos(lag=0.05), [0.01] * 5)
    assert trajectory[-1] == pytest.approx(0.01 * (1.0 - math.exp(-1.0)))


def test_backlash_is_lost_when_the_direction_changes() -> None:
    trajectory = servo_displacements(SimulatedServos(backlash=0.001), [0.01, 0.0095, 0.0])
    assert trajectory == pytest.approx([0.0095, 0.0095, 0.0005])


def test_a_period_has_its_mean_of_positions_and_the_middle_of_a_lagging_tension() -> None:
    moved = SimulatedActuators(SimulatedServos(), PERIOD, np.zeros(1)).follow_displacement(
        np.array([0.01]), np.zeros(1)
    )
    assert [float(one[0]) for one in moved] == [0.005, 0.01]
    ideal = SimulatedActuators(SimulatedServos(), PERIOD, np.zeros(1)).follow_tension(np.array([10.0]))
    assert [float(one[0]) for one in ideal] == [10.0, 10.0]
    lagging = SimulatedActuators(SimulatedServos(lag=0.05), PERIOD, np.zeros(1))
    middle, end = (float(one[0]) for one in lagging.follow_tension(np.array([10.0])))
    assert middle == pytest.approx(10.0 * (1.0 - math.exp(-0.1)))
    assert end == pytest.approx(10.0 * (1.0 - math.exp(-0.2)))


def mocap_samples(
    section: SimulatedMocap, steps: int, seed: int = 0, period: float = PERIOD
) -> list[tuple[int, int, bool]]:
    """Step, frame's exposure (as its stamp) and validity of what arrives."""
    mocap = Mocap(section, seed, Faults(4))
    arrivals = []
    for step in range(steps):
        pose = mocap.see(REST, step * period, step)
        if pose is not None:
            arrivals.append((step, pose.stamp_ns, pose.valid))
    return arrivals


def test_an_ideal_camera_measures_every_step_at_once() -> None:
    assert mocap_samples(SimulatedMocap(), 3) == [(0, 0, True), (1, 1, True), (2, 2, True)]


def test_latency_delays_frames_and_before_the_first_one_the_pose_is_that_at_rest() -> None:
    assert mocap_samples(SimulatedMocap(latency=0.02), 5) == [
        (0, 0, True),
        (1, 0, True),
        (2, 0, True),
        (3, 1, True),
        (4, 2, True),
    ]


def test_frames_come_at_the_cameras_rate() -> None:
    assert [step for step, *_ in mocap_samples(SimulatedMocap(period=0.01), 30, period=0.002)] == [0, 5, 10, 15, 20, 25]


def test_dropped_frames_do_not_come_and_hidden_ones_say_so() -> None:
    assert 300 < len(mocap_samples(SimulatedMocap(dropout=0.6), 1000)) < 500
    hidden = [
        not valid for *_, valid in mocap_samples(SimulatedMocap(period=0.01, occlusion=2.0, occlusion_time=0.1), 4000)
    ]
    assert 0.08 < np.mean(hidden) < 0.3  # hidden for 0.1 s every 0.6 s, on average


def test_noise_is_as_large_as_asked_and_the_same_for_the_same_seed() -> None:
    def positions(seed: int) -> np.ndarray:
        mocap = Mocap(SimulatedMocap(noise=1e-4, rotation_noise=1e-3), seed, Faults(4))
        return np.array([p.position for step in range(4000) if (p := mocap.see(REST, step * PERIOD, 0)) is not None])

    first = positions(1)
    assert first.std(axis=0) == pytest.approx([1e-4] * 3, rel=0.05)
    np.testing.assert_array_equal(first, positions(1))
    assert not np.array_equal(first, positions(2))


def plant(text: str) -> Plant:
    config = parse_config(text, "test")
    return Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))


def pulled(tension: float) -> TendonCommand:
    return TendonCommand(
        seq=0, stamp_ns=0, pose_seq=None, displacement=(0.0,) * 4, tension=(tension, 0.0, 0.0, 0.0), armed=True
    )


def test_a_swinging_weight_has_a_pendulums_period_and_the_weights_mean_pull() -> None:
    """Small swings of 0.3 m: 2 pi sqrt(l/g) = 1.10 s; the arm gives by some parts in a hundred more."""
    arm = plant("[simulator.weight]\nmass = 0.02\nstring = 0.3\n")
    forces = []
    for step in range(900):
        arm.step(pulled(3.0 if step > 50 else 0.0))
        forces.append(arm.observe(0)[2].tip_force)
    still = np.array(forces)[150:]
    assert still[:, 0].mean() == pytest.approx(-0.02 * 9.81, rel=0.01)
    sideways = still[:, 2] - still[:, 2].mean()
    crossings = np.flatnonzero((sideways[:-1] < 0.0) & (sideways[1:] >= 0.0))
    assert np.mean(np.diff(crossings)) * PERIOD == pytest.approx(1.10, rel=0.15)
    assert np.ptp(sideways[-200:]) < np.ptp(sideways[:200])


def test_an_impact_pushes_for_as_long_as_it_lasts() -> None:
    arm = plant("[[simulator.impacts]]\ntime = 0.05\nduration = 0.03\nforce = [2.0, 0.0, 0.0]\n")
    forces = []
    for _ in range(12):
        arm.step(pulled(0.0))
        forces.append(arm.observe(0)[2].tip_force[0])
    assert forces == [0.0] * 5 + [2.0] * 3 + [0.0] * 4


def injected(text: str, **options: object) -> Plant:
    arm = plant(text)
    assert arm.faults.cause(FaultRequest.model_validate(options)).done
    return arm


def test_a_stuck_servo_stays_where_it_is_until_the_fault_is_cleared() -> None:
    text = '[simulator]\ndrive = "displacement"\n[simulator.rod]\ntendon_stiffness = 2.0e4\n'
    arm = plant(text)
    pull = pulled(0.0).model_copy(update={"displacement": (0.01, 0.0, 0.0, 0.0)})
    for _ in range(100):
        arm.step(pull)
    before = arm.observe(0)[2].displacement[0]
    arm.faults.cause(FaultRequest(fault=Fault.STUCK, servo=1))
    further = pull.model_copy(update={"displacement": (0.03, 0.0, 0.0, 0.0)})
    for _ in range(60):
        arm.step(further)
    assert arm.observe(0)[2].displacement[0] == pytest.approx(before, abs=1e-5)
    arm.faults.cause(FaultRequest(fault=Fault.CLEAR, servo=1))
    for _ in range(60):
        arm.step(further)
    assert arm.observe(0)[2].displacement[0] > before + 0.008


def test_a_hardware_error_of_one_servo_releases_all_until_it_is_cleared() -> None:
    arm = injected("", fault=Fault.OVERLOAD, servo=2)
    arm.step(pulled(5.0))
    _, state, truth = arm.observe(0)
    assert state.fault == "servo 2: Overload Error (bit 5)"
    assert truth.tension == (0.0,) * 4
    arm.faults.cause(FaultRequest(fault=Fault.CLEAR))
    arm.step(pulled(5.0))
    assert arm.observe(0)[1].fault == ""
    assert arm.observe(0)[2].tension[0] == 5.0


def test_a_frozen_pose_continues_in_sequence_and_ends() -> None:
    arm = injected("", fault=Fault.FROZEN, seconds=0.2)
    poses = []
    for _ in range(40):
        poses.append(arm.observe(0)[0])
        arm.step(pulled(5.0))
    assert [pose.seq for pose in poses if pose] == list(range(40))
    places = np.array([pose.position for pose in poses if pose])
    assert np.ptp(places[:20], axis=0).max() == 0.0
    assert np.ptp(places[20:], axis=0).max() > 1e-3


def test_noise_and_teleports_are_measured_and_loads_act_for_as_long_as_asked() -> None:
    arm = injected("", fault=Fault.TELEPORT, size=0.1, direction="-y", seconds=0.05)
    measured_y = []
    for _ in range(10):
        pose = arm.observe(0)[0]
        assert pose is not None
        measured_y.append(pose.position[1])
        arm.step(pulled(0.0))
    assert measured_y == pytest.approx([-0.1] * 5 + [0.0] * 5)
    arm = injected("", fault=Fault.NOISE, size=1e-3, seconds=3.0)
    poses = [arm.observe(0)[0] for _ in range(500)]
    assert np.std([pose.position[1] for pose in poses if pose is not None]) == pytest.approx(1e-3, rel=0.2)
    assert None not in poses
    arm = injected("", fault=Fault.IMPACT, size=2.0, seconds=0.03)
    forces = []
    for _ in range(6):
        arm.step(pulled(0.0))
        forces.append(arm.observe(0)[2].tip_force[0])
    assert forces == [2.0] * 3 + [0.0] * 3


def test_no_command_pulls_more_than_the_rigs_own_limit_and_a_disarmed_one_pulls_nothing() -> None:
    config = parse_config("[limits]\ntension_max = 10.0\n", "test")
    plant = Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))

    def pulled(tension: float, *, armed: bool) -> float:
        command = TendonCommand(
            seq=0, stamp_ns=0, pose_seq=None, displacement=(0.0,) * 4, tension=(tension, 0.0, 0.0, 0.0), armed=armed
        )
        plant.step(command)
        return plant.observe(0)[2].tension[0]

    assert pulled(8.0, armed=True) == pytest.approx(8.0)
    assert pulled(500.0, armed=True) == pytest.approx(10.0)
    assert pulled(5.0, armed=False) == 0.0


def test_a_displacement_command_beyond_the_rigs_range_is_clamped() -> None:
    text = "[limits]\ndisplacement_max = 0.002\n[simulator]\ndrive = 'displacement'\n[simulator.rod]\n"
    config = parse_config(text + "tendon_stiffness = 2.0e4\n", "test")
    plant = Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))
    command = TendonCommand(
        seq=0, stamp_ns=0, pose_seq=None, displacement=(0.1, -0.002, -0.002, -0.002), tension=(0.0,) * 4, armed=True
    )
    for _ in range(5):
        plant.step(command)
    assert plant.observe(0)[1].displacement[0] == pytest.approx(0.002)
