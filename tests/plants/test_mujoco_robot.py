"""The plant by others against closed forms alone."""

import math
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

from tendond.drivers.mujoco.chain import SITE_GAP
from tests.plants.paper_robot import PaperRobot, Robot
from tests.plants.rig import MujocoRig, RigSettings

WEIGHTLESS = (0.0, 0.0, 0.0)


def frequency(robot: Robot) -> float:
    """Lowest natural frequency [Hz] of the straight, weightless, undamped chain, from its mass and stiffness."""
    plant = PaperRobot(robot)
    inertance = np.zeros((plant.model.nv, plant.model.nv))  # M^-1
    mujoco.mj_solveM(plant.model, plant.data, inertance, np.eye(plant.model.nv))
    stiffness = plant.model.jnt_stiffness[plant.model.dof_jntid].reshape(-1)
    flexibility = np.diag(1.0 / stiffness)
    return 1.0 / math.sqrt(float(eigh(flexibility, inertance, eigvals_only=True)[-1])) / (2.0 * math.pi)


def cantilever_frequency(robot: Robot, tip_mass: float) -> float:
    """First frequency of a uniform cantilever with an end mass [Hz] (Blevins, Formulas for Natural Frequency, 8-1)."""
    ratio = tip_mass / (robot.mass_per_length * robot.length)

    def characteristic(b: float) -> float:
        swing = math.cos(b) * math.sinh(b) - math.sin(b) * math.cosh(b)
        return 1.0 + math.cos(b) * math.cosh(b) + ratio * b * swing

    root = brentq(characteristic, 0.1, 2.0)
    return root**2 / (2.0 * math.pi) * math.sqrt(robot.bending_stiffness / robot.mass_per_length / robot.length**4)


def test_the_first_natural_frequency_is_the_papers_cantilevers() -> None:
    assert cantilever_frequency(Robot(), 0.0) == pytest.approx(3.7209, abs=1e-4)
    assert frequency(Robot(gravity=WEIGHTLESS)) == pytest.approx(3.7209, rel=2e-3)


@pytest.mark.parametrize("mass", [0.02, 0.05, 0.1])
def test_a_tip_mass_lowers_the_frequency_as_the_textbook_says(mass: float) -> None:
    robot = Robot(gravity=WEIGHTLESS, tip_mass=mass)
    assert frequency(robot) == pytest.approx(cantilever_frequency(robot, mass), rel=2e-3)


def test_a_mass_that_is_attached_later_is_one_that_was_there_from_the_start() -> None:
    plant = PaperRobot(Robot())
    plant.hang(0.05)
    plant.settle()
    assert plant.position == pytest.approx(PaperRobot(Robot(tip_mass=0.05)).position, abs=1e-6)


def test_it_rings_down_with_the_damping_of_the_rods_material() -> None:
    """Moment = EI u + Bbt u_t: the first mode's damping ratio is w Bbt / (2 EI)."""
    robot = Robot(gravity=WEIGHTLESS, damping=2e-4, drag=0.0, step=5e-4)
    plant = PaperRobot(robot)
    plant.push(np.array([0.01, 0.0, 0.0]))
    plant.settle()
    plant.push(np.zeros(3))
    heights = []
    for _ in range(1500):
        plant.advance(1e-3)
        heights.append(plant.position[0])
    x = np.array(heights)
    crossings = np.flatnonzero(np.diff(np.sign(x)) != 0)
    half = np.diff(crossings).mean() * 1e-3
    peaks = np.array([np.abs(x[a:b]).max() for a, b in pairwise(crossings)])
    ratio = -np.polyfit(np.arange(len(peaks)), np.log(peaks), 1)[0] / math.pi  # of light damping
    w = 2.0 * math.pi * cantilever_frequency(robot, 0.0)
    assert 1.0 / (2.0 * half) == pytest.approx(3.7209, rel=5e-3)
    assert ratio == pytest.approx(w * robot.damping / (2.0 * robot.bending_stiffness), rel=0.03)


@pytest.mark.parametrize(("tendon", "axis", "sign"), [(0, 0, 1), (1, 1, 1), (2, 0, -1), (3, 1, -1)])
def test_a_tendon_bends_the_weightless_rod_into_an_arc_to_its_own_side(tendon: int, axis: int, sign: int) -> None:
    """u = T r / EI, the same all along."""
    robot = Robot(gravity=WEIGHTLESS)
    plant = PaperRobot(robot)
    tension = np.zeros(4)
    tension[tendon] = 20.0
    plant.set_tension(tension)
    plant.settle()
    h = robot.length / robot.links
    u = brentq(  # the tendon's arm at a joint of the chain is r cos(a/2) + g h sin(a/2), a = u h
        lambda u: (
            robot.bending_stiffness * u - 20.0 * (0.02 * math.cos(u * h / 2.0) + SITE_GAP * h * math.sin(u * h / 2.0))
        ),
        0.0,
        20.0,
    )
    assert u == pytest.approx(20.0 * 0.02 / robot.bending_stiffness, rel=0.01)
    expected = np.zeros(3)
    expected[axis] = sign * (1.0 - math.cos(u * robot.length)) / u
    expected[2] = math.sin(u * robot.length) / u
    assert plant.position == pytest.approx(expected, abs=3e-4 * robot.length)


def test_a_dead_force_on_the_tip_bends_the_rod_into_the_elastica() -> None:
    """P L^2 / EI = 5 of Bisshopp and Drucker, Quarterly of Applied Mathematics 3 (1945)."""
    robot = Robot(gravity=WEIGHTLESS, links=40)
    load = 5.0
    plant = PaperRobot(robot)
    plant.push(np.array([load * robot.bending_stiffness / robot.length**2, 0.0, 0.0]))
    plant.settle()

    def length(angle: float) -> float:
        k = math.sqrt(0.5 * (1.0 + math.sin(angle)))
        start = math.asin(1.0 / (k * math.sqrt(2.0)))
        return float(ellipkinc(math.pi / 2.0, k**2) - ellipkinc(start, k**2)) - math.sqrt(load)

    tip = brentq(length, 0.01, math.pi / 2.0 - 1e-6)
    k = math.sqrt(0.5 * (1.0 + math.sin(tip)))
    start = math.asin(1.0 / (k * math.sqrt(2.0)))
    arc = float(ellipeinc(math.pi / 2.0, k**2) - ellipeinc(start, k**2))
    across = robot.length * (1.0 - 2.0 * arc / math.sqrt(load))
    along = robot.length * math.sqrt(2.0 * math.sin(tip) / load)
    assert across / robot.length == pytest.approx(0.71379, abs=1e-4)  # their table has 0.714
    assert plant.position == pytest.approx([across, 0.0, along], abs=1e-3 * robot.length)


def test_a_displacement_command_holds_the_same_shape_as_its_tension() -> None:
    """The ends' displacement is the tendon's shortening and its stretch."""
    plant = PaperRobot(Robot(step=5e-4))
    plant.set_tension(np.array([20.0, 0.0, 0.0, 0.0]))
    plant.settle()
    pulled, shortening = plant.position, plant.displacement
    plant.set_displacement(np.array([shortening[0] + 20.0 / plant.robot.stiffness, -0.1, -0.1, -0.1]))
    plant.settle()
    assert plant.position == pytest.approx(pulled, abs=1e-5)
    assert plant.tension == pytest.approx([20.0, 0.0, 0.0, 0.0], abs=1e-3)


def test_a_camera_shows_where_the_tip_was() -> None:
    rig = MujocoRig(Robot(), RigSettings(delay=2))
    truth, reported = [], []
    for _ in range(8):
        truth.append(rig.plant.position)
        reported.append(rig.pose()[0])
        rig.advance(np.array([5.0, 0.0, 0.0, 0.0]), np.zeros(4), True)
    assert np.array_equal(reported[2:], truth[:-2])
    assert not np.array_equal(truth[-1], truth[-3])
