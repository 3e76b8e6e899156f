"""A base anywhere in the room: controller, simulator and camera work in its frame; SciPy turns the rest."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.mocap.frames import Frame
from tendond.drivers.mocap.geometry import Placement, placed
from tendond.drivers.mocap.poses import PoseBuilder
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.model.rods.selection import model_rod
from tendond.model.strain.rod import StrainRod
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.requests import ControlAction

TURN = Rotation.from_rotvec([0.4, -1.3, 0.8])
PLACE = np.array([1.0, -0.3, 2.2])
W, X, Y, Z = np.roll(TURN.as_quat(), 1).tolist()
POSE = {"position": PLACE.tolist(), "orientation": (W, X, Y, Z)}
GRAVITY = np.array([0.0, 0.0, -9.81])


def mounted(**rod: object) -> RigConfig:
    return same({**rod, "gravity": GRAVITY.tolist(), "base": POSE})


def same(rod: dict[str, object]) -> RigConfig:
    reference = {"across": 0.2, "unreachable": "track"}  # gravity from the side holds the tip out of the plane
    return check_config({"rod": rod, "reference": reference}, "rig")


def test_the_controllers_robot_is_the_one_in_the_room_seen_from_its_base() -> None:
    config = mounted(preset="rao-2021")
    room, rod = StrainRod.from_config(config), model_rod(config)
    tensions, force = np.linspace(0.5, 2.0, len(config.rod.tendon_positions)), np.array([0.02, 0.01, -0.03])
    position, rotation = room.tip(room.solve_static(room.loads(tensions, tip_force=TURN.apply(force))))
    tip = rod.tip(rod.solve_static(tensions, tip_force=force))
    assert tip.position == pytest.approx(TURN.inv().apply(position - PLACE), abs=1e-8)
    assert tip.rotation == pytest.approx(TURN.inv().as_matrix() @ rotation, abs=1e-7)


@pytest.mark.parametrize("turned", [True, False])
def test_a_turned_base_runs_as_the_same_robot_under_gravity_from_its_side(turned: bool) -> None:
    level = same({"gravity": TURN.inv().apply(GRAVITY).tolist()})
    config = mounted() if turned else same({"gravity": GRAVITY.tolist()})
    tips = [
        np.array([record.model.position for record in closed_loop(one, 40, {2: ControlAction.ARM})])
        for one in (config, level)
    ]
    assert (np.abs(tips[0] - tips[1]).max() < 1e-7) == turned  # without the turn the rod sags the other way


def test_a_mounted_robot_reads_back_to_the_last_bit() -> None:
    for config in (mounted(), mounted(preset="rao-2021")):
        again = check_config(config.model_dump(), "again")
        assert again == config
        assert again.rod.base_gravity == config.rod.base_gravity
        assert (
            CycleSetup.from_config(again).rod.parameters.gravity
            == CycleSetup.from_config(config).rod.parameters.gravity
        )


def test_a_camera_that_sees_no_base_takes_its_pose_from_the_configuration() -> None:
    config = mounted()
    tip = Rotation.from_rotvec([0.1, 0.2, 0.3])
    there = Placement(PLACE + TURN.apply([0.05, 0.0, 0.2]), (TURN * tip).as_matrix())
    builder = PoseBuilder(ViconSection(base=""), config.rod.base_gravity, placed(config.rod.base))
    pose = builder.build(Frame(1, {"tip": there}, 1))
    assert pose is not None
    assert pose.valid
    assert pose.position == pytest.approx((0.05, 0.0, 0.2), abs=1e-12)
    assert np.abs(np.roll(pose.orientation, -1) @ tip.as_quat()) == pytest.approx(1.0)
