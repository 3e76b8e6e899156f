"""A rig and its mirror image: what holds for a tendon that bends towards +x holds for the one that bends towards -x."""

import numpy as np
import pytest

from tendond.daemon.control.reference.planar import PLANES, PlanarReference
from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

AGONISTS = {"xz": {1: 0, -1: 2}, "yz": {1: 1, -1: 3}}
"""Agonist of each bending plane and side."""


def past_target(plane: str, side: int) -> list[CycleRecord]:
    """A run in which an impact throws the arm over its base; the plant is softer and less damped than the model."""
    gravity = [0.0, 0.0, 0.0]
    gravity[PLANES[plane][0]] = -9.81 * side
    text = (
        f'[rod]\ngravity = {gravity}\n[control]\nplane = "{plane}"\nagonist = {AGONISTS[plane][side]}\n'
        f"[reference]\nacross = {0.34 * side}\n"
        "[[simulator.impacts]]\ntime = 1.0\nduration = 0.05\nforce = [0.0, 0.0, 10.0]\n"
        f"[simulator.rod]\ngravity = {gravity}\nyoungs_modulus = 1.615e11\nbending_damping = [0.004, 0.004, 0.004]\n"
    )
    return list(closed_loop(parse_config(text, "test"), 300, {5: ControlAction.ARM}))


@pytest.mark.parametrize(("plane", "side"), [("xz", -1), ("yz", -1), ("yz", 1)])
def test_an_arm_that_bends_to_any_side_comes_back_when_it_is_past_its_target(plane: str, side: int) -> None:
    original, image = past_target("xz", 1), past_target(plane, side)
    across = [side * r.measured[PLANES[plane][0]] for r in image[100:] if r.measured is not None]
    assert min(across) < 0.1
    assert image[-1].mode is Mode.TRACKING
    assert across[-1] == pytest.approx(0.34, abs=2e-3)
    pulled = [
        [r.command.tension[agonist] for r in run] for run, agonist in ((original, 0), (image, AGONISTS[plane][side]))
    ]
    assert np.allclose(pulled[0], pulled[1], atol=1e-3)


@pytest.mark.parametrize("side", [1, -1])
def test_bent_beyond_the_target_is_judged_on_the_side_to_which_the_agonist_bends(side: int) -> None:
    config = parse_config(
        f"[rod]\ngravity = [{-9.81 * side}, 0.0, 0.0]\n[simulator.rod]\ngravity = [{-9.81 * side}, 0.0, 0.0]\n"
        f"[control]\nagonist = {AGONISTS['xz'][side]}\n[reference]\nacross = {0.2 * side}\n",
        "test",
    )
    reference = CycleSetup.from_config(config).selection.reference
    assert isinstance(reference, PlanarReference)
    assert reference.arc is not None
    rest = float(reference.curve.tension_at(reference.arc))
    target = side * abs(float(np.interp(reference.arc, reference.curve.arc, reference.curve.angle)))
    for beyond, expected in ((0.6, rest), (0.4, None), (-0.6, None), (-1.5, None)):
        angle = target + side * beyond
        assert reference.past_target(np.array([np.sin(angle), 0.0, np.cos(angle)])) == expected
