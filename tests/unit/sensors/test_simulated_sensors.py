"""Simulated sensors: their rows are the rod's own shape and motion, computed here from its nodes in another way."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import GeneralPlantRod, PlantRod, plant_rod
from tendond.drivers.simulator.sensors import Truth, true_rows
from tendond.model.rods.selection import rod_from_section
from tendond.model.strain.analysis.frames import frames, strain_at
from tendond.model.strain.describe.configured import robot_from_section
from tendond.model.strain.rod import StrainRod
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.sensors.section import SensorSection
from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.messages import SensorReading, TendonCommand

GRAVITY = RigConfig().rod.base_gravity
PULL = np.array([6.0, 3.0, 0.0, 0.0])
BENT = np.array([0.06, 0.21, 0.33, 0.49])
OFFSETS = ((0.02, 0.0, 0.0), (0.0, 0.02, 0.0), (0.0, 0.0, 0.01), (0.01, -0.02, 0.0))
SOLVERS = ("shooting", "general")


def section(kind: str, **keys: Any) -> SensorSection:
    noise = [1e-9, 1e-9] if kind in ("imu", "base") else 1e-9
    return SensorSection.model_validate({"name": kind, "kind": kind, "noise": noise, **keys})


def plant_of(solver: str, time_step: float = 0.01) -> PlantRod:
    return plant_rod(RigConfig().simulator.model_copy(update={"solver": solver}), time_step)


def at_rest(solver: str) -> Truth:
    rod = plant_of(solver)
    state = rod.solve_static(PULL)
    return Truth(rod, state, state, PULL, GRAVITY)


def fine_frames(at: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """Nodes of a shooting rod so fine that one of them is at each place: positions and orientations, of all nodes."""
    rod = rod_from_section(RigConfig().rod.model_copy(update={"nodes": 501}), 0.01)
    state = rod.solve_static(PULL)
    assert np.allclose(at / rod.parameters.length * 500.0 % 1.0, 0.0)
    return state.shape, Rotation.from_matrix(state.rotations)


@pytest.mark.parametrize("solver", SOLVERS)
def test_markers_are_where_the_nodes_of_a_fine_rod_are(solver: str) -> None:
    positions, turns = fine_frames(BENT)
    nodes = np.rint(BENT * 1000.0).astype(int)
    expected = positions[nodes] + turns[nodes].apply(np.array(OFFSETS))
    found = true_rows(section("markers", at=BENT.tolist(), offset=OFFSETS), at_rest(solver))
    assert np.abs(positions[nodes][:, :2]).max() > 0.05  # it is bent
    assert np.abs(found - expected).max() < 2e-5


@pytest.mark.parametrize("solver", SOLVERS)
def test_curvature_is_the_difference_of_frames_along_the_rod(solver: str) -> None:
    _, turns = fine_frames(BENT)
    nodes = np.rint(BENT * 1000.0).astype(int)
    expected = (turns[nodes - 1].inv() * turns[nodes + 1]).as_rotvec()[:, :2] / 0.002
    found = true_rows(section("curvature", at=BENT.tolist()), at_rest(solver))
    assert np.abs(expected).max() > 0.5
    assert np.abs(found - expected).max() < 0.005 * np.abs(expected).max()


@pytest.mark.parametrize("solver", SOLVERS)
def test_the_ends_of_the_backbone_are_base_and_tip(solver: str) -> None:
    truth = at_rest(solver)
    found = true_rows(section("markers", at=[0.0, 0.5]), truth)
    tip = truth.rod.tip(truth.state)
    assert found == pytest.approx(np.array([np.zeros(3), tip.position]), abs=1e-12)
    ahead = true_rows(section("markers", at=[0.5], offset=[0.0, 0.0, 1.0]), truth)
    assert ahead[0] - tip.position == pytest.approx(tip.rotation[:, 2], abs=1e-12)


def test_the_general_rods_cross_sections_are_those_of_the_models_analysis() -> None:
    """Sections of their own modes, curved without load; places at nodes, between them, and where sections meet."""
    sections = [
        {"length": 0.2, "radius": 1e-3, "youngs_modulus": 60e9, "density": 6500.0, "precurvature": [1.0, 0.5, 2.0]},
        {"length": 0.1, "radius": [[0.0, 1e-3], [0.1, 5e-4]], "youngs_modulus": 60e9, "density": 6500.0},
    ]
    tendons = [{"position": [0.01, 0.0], "turns": 0.4}, {"position": [0.0, 0.01], "end": 0.2}]
    robot = robot_from_section(RodSection.model_validate({"section": sections, "tendon": tendons}))
    rod, kernels = GeneralPlantRod(robot, 0.01), StrainRod(robot, 0.01)
    state = rod.solve_static(np.array([3.0, 2.0]))
    at = np.array([0.0, 0.013, 0.1, 0.2, 0.2001, 0.27, 0.3])
    position, rotation, strain = rod.cross_sections(state, at)
    expected = frames(kernels, state.strain, at)
    assert position == pytest.approx(expected[:, :3, 3], abs=1e-13)
    assert rotation == pytest.approx(expected[:, :3, :3], abs=1e-12)
    assert strain == pytest.approx(strain_at(kernels, state.strain, at), abs=1e-11)
    assert np.abs(strain[:, :3]).max() > 3.0


def moving(solver: str, step: float) -> Iterator[Truth]:
    """A rod that is let go and pulled again, smoothly: the truth of each step."""
    rod = plant_of(solver, step)
    state = rod.solve_static(PULL)
    for i in range(round(0.3 / step)):
        before, state = state, rod.step(state, PULL * math.cos(math.pi * i * step / 0.3) ** 2)
        yield Truth(rod, before, state, np.zeros(4), GRAVITY)


@pytest.mark.parametrize("solver", SOLVERS)
def test_an_imu_has_the_differences_of_the_tips_frames_in_time(solver: str) -> None:
    step = 0.001
    truths = list(moving(solver, step))
    tips = [one.rod.tip(one.state) for one in truths]
    places, turns = np.array([tip.position for tip in tips]), Rotation.from_matrix([tip.rotation for tip in tips])
    rates = (turns[:-2].inv() * turns[2:]).as_rotvec() / (2.0 * step)
    accelerations = (places[2:] - 2.0 * places[1:-1] + places[:-2]) / step**2
    rows = np.array([true_rows(section("imu"), one)[0] for one in truths])
    felt = np.array(
        [turn.inv().apply(a - np.array(GRAVITY)) for turn, a in zip(turns[1:-1], accelerations, strict=True)]
    )
    assert np.abs(rates).max() > 1.0
    assert np.abs(accelerations).max() > 3.0
    late = 0.04 if solver == "general" else 0.005  # the general rod's are of its last steps, not of an instant
    assert np.abs(rows[1:-1, :3] - rates).max() < late * np.abs(rates).max()
    assert np.abs(rows[1:-1, 3:] - felt).max() < late * np.abs(accelerations).max()


@pytest.mark.parametrize("solver", SOLVERS)
def test_an_imu_at_rest_feels_gravity_alone(solver: str) -> None:
    truth = at_rest(solver)
    (row,) = true_rows(section("imu"), truth)
    assert row[:3] == pytest.approx(np.zeros(3), abs=1e-12)
    assert truth.rod.tip(truth.state).rotation @ row[3:] == pytest.approx(-np.array(GRAVITY), abs=1e-9)


def test_load_cells_have_the_pull_of_their_tendons_and_the_base_stands() -> None:
    truth = at_rest("general")
    assert true_rows(section("tension", tendons=[1, 0]), truth).tolist() == [[3.0], [6.0]]
    assert true_rows(section("base"), truth).tolist() == [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]


TEXT = """\
[[sensors]]
name = "skin"
kind = "markers"
at = [0.1, 0.2, 0.3]
noise = 1e-3
[[sensors]]
name = "late"
kind = "curvature"
at = [0.3]
noise = 1e-6
delay = 0.025
rate = 30.0
[[sensors]]
name = "vehicle"
kind = "base"
noise = [1e-3, 1e-2]
"""


def rig() -> Plant:
    config = parse_config(TEXT, "t")
    return Plant(config, plant_rod(config.simulator, 0.01))


def run(plant: Plant, steps: int, name: str) -> list[SensorReading | None]:
    found = []
    for _ in range(steps):
        plant.observe(round(plant.time * 1e9))
        found.append(plant.readings.get(name))
        plant.step(None)
    return found


def test_a_reading_comes_at_its_rate_and_after_its_delay() -> None:
    plant = rig()
    found = {tick: one for tick, one in enumerate(run(plant, 300, "late")) if one is not None}
    assert [one.seq for one in found.values()] == list(range(len(found)))
    assert len(found) == pytest.approx(90, abs=1)
    ages = {round(tick * 0.01 - one.stamp_ns * 1e-9, 9) for tick, one in found.items()}
    assert ages == {0.03}  # the first look after the delay has passed


def test_noise_has_its_deviation_and_a_seed_gives_the_same_again() -> None:
    found = run(rig(), 200, "skin")
    rows = np.array([one.rows for one in found if one is not None])
    assert rows.shape == (200, 3, 3)
    assert rows.std(axis=0) == pytest.approx(1e-3, rel=0.2)
    assert found == run(rig(), 200, "skin")
    poses = np.array([one.rows[0] for one in run(rig(), 200, "vehicle") if one is not None])
    assert poses[:, :3].std(axis=0) == pytest.approx(1e-3, rel=0.2)
    assert 2.0 * poses[:, 4:].std(axis=0) == pytest.approx(1e-2, rel=0.2)
    assert np.linalg.norm(poses[:, 3:], axis=1) == pytest.approx(1.0)


def test_markers_are_hidden_swapped_and_a_sensor_is_mute_as_long_as_asked_for() -> None:
    plant = rig()

    def after(**request: Any) -> list[Any]:
        assert plant.faults.cause(FaultRequest.model_validate({"sensor": "skin", "seconds": 0.02, **request})).done
        found = [
            one and [None if row is None else round(row[2], 1) for row in one.rows] for one in run(plant, 3, "skin")
        ]
        assert found[2] == [0.1, 0.2, 0.3]  # it is over
        return found[:2]

    assert after(fault=Fault.UNSEEN, rows=(0, 2)) == [[None, 0.2, None]] * 2
    assert after(fault=Fault.UNSEEN) == [[None] * 3] * 2
    assert after(fault=Fault.SWAPPED) == [[0.2, 0.1, 0.3]] * 2
    assert after(fault=Fault.SWAPPED, rows=(2, 1)) == [[0.1, 0.3, 0.2]] * 2
    assert after(fault=Fault.MUTE) == [None] * 2
    plant.faults.cause(FaultRequest(fault=Fault.MUTE, sensor="skin", seconds=1.0))
    assert plant.faults.cause(FaultRequest(fault=Fault.CLEAR)).done
    assert run(plant, 1, "skin") != [None]


def test_a_fault_of_a_sensor_that_cannot_be_is_refused_with_what_there_is() -> None:
    faults = rig().faults
    unknown = faults.cause(FaultRequest(fault=Fault.MUTE, sensor="skn"))
    assert (unknown.done, unknown.message) == (
        False,
        "there is no sensor 'skn'; [[sensors]] of the simulator's configuration has: skin, late, vehicle",
    )
    assert (
        "has no row 3; its rows are 0 to 2"
        in faults.cause(FaultRequest(fault=Fault.UNSEEN, sensor="skin", rows=(3,))).message
    )
    assert not faults.cause(FaultRequest(fault=Fault.SWAPPED, sensor="late")).done
    for wrong, said in (
        ({"fault": "mute"}, "mute needs a sensor: give its name"),
        ({"fault": "mute", "sensor": "skin", "rows": [0]}, "mute takes no rows"),
        ({"fault": "swapped", "sensor": "skin", "rows": [1]}, "swapped: give two different rows"),
    ):
        with pytest.raises(ValueError, match=said):
            FaultRequest.model_validate(wrong)


def test_the_tension_of_the_first_tendon_is_what_pulls_it() -> None:
    config = parse_config('[[sensors]]\nname = "cells"\nkind = "tension"\ntendons = [0]\nnoise = 1e-9\n', "t")
    plant = Plant(config, plant_rod(config.simulator, 0.01))
    nothing = (0.0,) * 4
    plant.step(TendonCommand(seq=0, stamp_ns=0, pose_seq=0, displacement=nothing, tension=(5.0, 0, 0, 0), armed=True))
    plant.observe(0)
    assert plant.readings["cells"].rows[0] == pytest.approx((5.0,), abs=1e-6)
