"""The MuJoCo plant behind the simulator's interface: beside the own plant, and what it refuses."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from tendond.drivers.simulator.cross_sections import cross_sections, tip_motion
from tendond.drivers.simulator.lockstep import open_loop, watched_loop
from tendond.drivers.simulator.mujoco_chain import chain_of
from tendond.drivers.simulator.mujoco_rod import STEP_MAX, MujocoRod, stable_step
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import plant_rod
from tendond.model.errors import ParameterError
from tendond.model.strain.describe.configured import robot_from_section
from tendond.offline.bench.plants import compare
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.simulator import SimulatorSection
from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.requests import ControlAction
from tests.unit.cli.commands import tendond

LENGTH = 0.5
LIGHT = {"bending_damping": [2e-3] * 3}
TWO_SECTIONS = {
    "section": [
        {"length": 0.2, "radius": 1e-3, "youngs_modulus": 190e9, "density": 8000.0, "bending_damping": [0.004] * 3,
         "disk_number": 2, "disk_mass": 0.004},
        {"length": 0.15, "radius": 0.7e-3, "youngs_modulus": 190e9, "density": 8000.0, "bending_damping": [0.002] * 3},
    ],
    "tendon": [{"position": [0.01, 0.0], "end": 0.2}, {"position": [-0.008, 0.0]}],
    "tip": {"mass": 0.01, "offset": [0.0, 0.0, 0.01]},
}  # fmt: skip


def rig(**simulator: object) -> RigConfig:
    """Return a rig whose plant has the model's robot, by the key `rod`."""
    rod = simulator.pop("rod", {})
    return check_config({"rod": rod, "simulator": {"solver": "mujoco", **simulator}}, "test")


def pulls(tensions: tuple[float, ...], cycles: int, displacement: float = 0.0) -> Iterator[TendonCommand]:
    ends = (displacement, *(-0.01 for _ in tensions[1:]))
    for seq in range(cycles):
        yield TendonCommand(seq=seq, stamp_ns=0, pose_seq=None, displacement=ends, tension=tensions, armed=True)


@pytest.fixture(scope="module")
def rod() -> MujocoRod:
    return MujocoRod(SimulatorSection(solver="mujoco"), 0.01)


def test_every_row_of_the_comparison_with_the_own_plant_meets_its_goal() -> None:
    """Shapes, frequencies and the loop: `tendond bench plants` for one law."""
    rows = list(compare(RigConfig(), ("backstepping",)))
    assert len(rows) == 11
    assert [row for row in rows if not row.meets] == []
    assert max(row.apart or 0.0 for row in rows[:5]) > 0.0, "two plants, not one twice"


@pytest.mark.parametrize("pulled", [0, 1])
def test_a_robot_of_sections_rests_where_the_general_rod_does(pulled: int) -> None:
    """Disks, a tool beside the tip, and a tendon that ends before it."""
    tensions = np.zeros(2)
    tensions[pulled] = 6.0
    tips = []
    for solver in ("general", "mujoco"):
        plant = plant_rod(rig(solver=solver, rod=TWO_SECTIONS).simulator, 0.01)
        tips.append(plant.tip(plant.solve_static(tensions)).position)
    assert np.linalg.norm(tips[0] - tips[1]) < 0.005 * 0.35
    assert np.linalg.norm(tips[0] - [0.0, 0.0, 0.35]) > 0.003


def test_a_state_may_be_gone_back_to(rod: MujocoRod) -> None:
    start = rod.solve_static()
    first = rod.step(start, [8.0, 0.0, 0.0, 0.0])
    rod.step(first, [20.0, 0.0, 0.0, 0.0])
    again = rod.step(start, [8.0, 0.0, 0.0, 0.0])
    assert again.position == pytest.approx(first.position, abs=1e-12)
    assert again.rates == pytest.approx(first.rates, abs=1e-9)
    assert np.linalg.norm(first.position - start.position) > 1e-4


def test_a_run_is_the_same_again() -> None:
    runs = [[truth for _, truth in open_loop(rig(), pulls((12.0, 0.0, 3.0, 0.0), 20))] for _ in range(2)]
    assert runs[0] == runs[1]


def test_displacement_drives_it_through_elastic_tendons() -> None:
    """The servos stand where they are sent, and the tendon is longer than the path by T/k."""
    config = rig(drive="displacement", rod={"tendon_stiffness": 2e4})
    *_, (state, truth) = open_loop(config, pulls((0.0,) * 4, 200, 0.02))
    assert state.displacement[0] == pytest.approx(0.02)
    assert truth.displacement[0] + truth.tension[0] / 2e4 == pytest.approx(0.02, abs=1e-6)
    assert truth.tension[0] > 5.0
    assert truth.position[0] > 0.1


@pytest.mark.parametrize(
    "request_",
    [
        FaultRequest(fault=Fault.WEIGHT, size=0.03),
        FaultRequest(fault=Fault.IMPACT, size=1.0, direction="y", seconds=0.2, place=0.6),
        FaultRequest(fault=Fault.IMPACT, size=1.0, direction="y", seconds=0.2),
        FaultRequest(fault=Fault.CUT, servo=1),
    ],
    ids=lambda one: f"{one.fault.value} {one.place or ''}",
)
def test_loads_and_servo_faults_act_on_it_as_on_the_own_plant(request_: FaultRequest) -> None:
    moved = []
    for solver in ("general", "mujoco"):
        config = rig(solver=solver)
        plant, tips = Plant(config, plant_rod(config.simulator, 0.01)), []
        for caused in (False, True):
            if caused:
                assert plant.faults.cause(request_).done
            for command in pulls((6.0, 0.0, 0.0, 0.0), 1 if caused else 80):
                plant.step(command)
            for _ in range(14 if caused else 0):
                plant.step(None)
            tips.append(np.array(plant.observe(0)[2].position))
        moved.append(tips[1] - tips[0])
    assert np.linalg.norm(moved[1]) > 0.005
    assert np.linalg.norm(moved[1] - moved[0]) < 0.15 * np.linalg.norm(moved[0])


def test_sensors_see_the_bent_chain_as_they_see_the_rod(rod: MujocoRod) -> None:
    own = plant_rod(SimulatorSection(solver="general"), 0.01)
    at, tensions = np.array([0.1, 0.3, 0.5]), [15.0, 0.0, 0.0, 0.0]
    found = [cross_sections(one, one.solve_static(tensions), at) for one in (own, rod)]
    assert found[1].position == pytest.approx(found[0].position, abs=2e-3)
    assert found[1].rotation == pytest.approx(found[0].rotation, abs=0.02)
    assert found[1].curvature[:2] == pytest.approx(found[0].curvature[:2], abs=0.05)
    rest = rod.solve_static()
    rate, acceleration = tip_motion(rod, rest, rod.step(rest, tensions))
    assert rate[1] > 0.1  # towards +x
    assert acceleration[0] > 1.0


def test_the_step_is_finer_where_the_rod_hardly_damps_and_is_stable() -> None:
    heavy, light = (MujocoRod(rig(rod=keys).simulator, 0.01) for keys in ({}, {"bending_damping": [1e-5] * 3}))
    assert heavy.chain.step == STEP_MAX
    assert light.chain.step < STEP_MAX
    state = light.solve_static()
    for _ in range(50):
        state = light.step(state, [15.0, 0.0, 0.0, 0.0])
    assert np.linalg.norm(state.position) <= LENGTH
    with pytest.raises(ParameterError, match=r"rod\.bending_damping: too light for the MuJoCo plant"):
        MujocoRod(rig(rod={"bending_damping": [0.0] * 3, "radius": 4e-3, "density": 200.0}).simulator, 0.01)


def test_a_winch_stiffens_the_plant_that_its_step_must_follow() -> None:
    robot = MujocoRod(rig(rod=LIGHT | {"tendon_stiffness": 1e5}).simulator, 0.01)._robot
    assert stable_step(robot, by_winch=True) < stable_step(robot, by_winch=False)


@pytest.mark.parametrize(
    ("simulator", "message"),
    [
        ({"rod": {"tendon_friction": 0.1}}, "rod.tendon_friction: tendon 0: the MuJoCo plant has none"),
        ({"servo": {"friction": 0.1}}, "simulator.servo.friction: the MuJoCo plant's tendons do not rub"),
        ({"rod": {"precurvature": [0.0, 1.0, 0.0]}}, "precurvature: the MuJoCo plant is straight without load"),
        (
            {"rod": {"tendon": [{"position": [0.01, 0.0], "turns": 0.5}]}},
            "rod.tendon[0]: winds round the rod and twists it",
        ),
    ],
)
def test_a_robot_that_a_chain_cannot_be_is_refused_in_a_line(simulator: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError) as caught:
        plant_rod(rig(**simulator).simulator, 0.01)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_exported_model_is_the_plant(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "robot.xml"
    assert tendond(capsys, "config", "mjcf", "--out", str(file)).status == 0
    model = mujoco.MjModel.from_xml_path(str(file))
    assert model.nv == 90
    assert model.ntendon == 4
    assert model.nu == 8
    assert float(model.body_mass.sum()) == pytest.approx(17189.0 * np.pi * 1e-6 * (LENGTH - LENGTH / 60.0), rel=1e-6)
    data = mujoco.MjData(model)
    data.ctrl[:4] = (15.0, 0.0, 0.0, 0.0)
    data.ctrl[4:] = 10.0
    model.dof_damping[:] *= 3.0
    for _ in range(4000):
        mujoco.mj_step(model, data)
    plant = MujocoRod(SimulatorSection(solver="mujoco"), 0.01)
    expected = plant.solve_static([15.0, 0.0, 0.0, 0.0]).position
    assert data.site("tip").xpos == pytest.approx(expected, abs=1e-4)
    refused = tendond(capsys, "config", "mjcf", "--out", str(file))
    assert refused.status == 1
    assert "is there already" in refused.said


def test_the_loop_tracks_on_it_by_displacement_with_noise_and_delay() -> None:
    config = check_config(
        {
            "rod": {"tendon_stiffness": 2e4},
            "limits": {"slack": 0.002},
            "observer": {"delay": 0.01},
            "simulator": {"solver": "mujoco", "drive": "displacement", "mocap": {"latency": 0.01, "noise": 1e-4}},
        },
        "test",
    )
    run = list(watched_loop(config, 300, {20: ControlAction.ARM}))
    assert run[-1].record.mode is Mode.TRACKING
    assert run[-1].truth.position[0] == pytest.approx(0.34, abs=2e-3)


def test_the_chain_has_the_tables_of_a_section_in_series() -> None:
    """Half a section twice as stiff: the joints there are, and their damping too."""
    tapered = rig(rod={"section": [{"length": 0.4, "radius": [[0.0, 2e-3], [0.4, 1e-3]], "youngs_modulus": 70e9,
                                    "density": 2700.0, "bending_damping": [0.02] * 3}],
                       "tendon": [{"position": [0.01, 0.0]}]})  # fmt: skip
    links = chain_of(robot_from_section(tapered.simulator.rod)).links
    radius = 2e-3 - 1e-3 * (15.5 / 30.0)
    assert links[15].bending_stiffness == pytest.approx(70e9 * np.pi * radius**4 / 4.0, rel=2e-3)
    assert links[0].bending_stiffness > 10.0 * links[-1].bending_stiffness
    assert links[15].damping == pytest.approx(0.02, rel=1e-6)
