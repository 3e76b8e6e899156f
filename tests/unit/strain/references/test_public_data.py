"""The strain rod against figures published by others; skipped where TENDOND_REFERENCE_DATA does not name their folder.

What they are, and where to get them: offline/bench/general_rod/others.py.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from tendond.offline.bench.general_rod import others
from tendond.offline.bench.general_rod.references import STEP_TOLERANCE

FOLDER = Path(os.environ.get(others.VARIABLE, ""))

pytestmark = pytest.mark.skipif(
    not os.environ.get(others.VARIABLE),
    reason=f"{others.VARIABLE} does not name a folder with others' data: see the page on the general rod",
)


@pytest.mark.parametrize("material", list(others.MATERIALS))
def test_five_hundred_equilibria_under_wrenches_at_middle_and_tip(material: str) -> None:
    if not others.statics_file(FOLDER, material).exists():
        pytest.skip(f"{others.statics_file(FOLDER, material)} is not there")
    errors = others.equilibria(FOLDER, material)
    assert len(errors) == 500
    assert np.median(errors) < 0.0005
    assert max(errors) < 0.005


@pytest.mark.parametrize(("time_step", "bound"), STEP_TOLERANCE.items())
def test_releases_of_a_steel_rod_keep_to_the_others_path_for_ten_seconds(time_step: float, bound: float) -> None:
    if not others.release_file(FOLDER, 1).exists():
        pytest.skip(f"{others.release_file(FOLDER, 1)} is not there")
    assert np.mean([np.mean(others.release(FOLDER, number, time_step)) for number in others.RELEASES]) < bound


def test_a_soft_rod_with_two_tendons_is_closer_to_two_others_than_they_are_to_each_other() -> None:
    if not others.rollout_file(FOLDER, "soromox").exists():
        pytest.skip(f"{others.rollout_file(FOLDER, 'soromox')} is not there")
    found = others.two_tendons(FOLDER)
    assert found["between"] == pytest.approx(4.8e-3, rel=0.01)
    assert max(found["soromox"], found["sorosim"]) < found["between"]
