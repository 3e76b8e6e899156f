"""The strain rod against figures published by others; skipped where TENDOND_REFERENCE_DATA does not name their folder.

github.com/ContinuumRoboticsLab/opencr-mujoco @17fff8b (MIT), data/reference/sorosim: equilibria and releases of a steel
rod by SoRoSim, under wrenches at its middle and its tip.
"""

import csv
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendond.model.strain import Robot, Section, StrainRod

FOLDER = Path(os.environ.get("TENDOND_REFERENCE_DATA", "")) / "opencr-mujoco"
STATICS = FOLDER / "sorosim_statics" / "SpringSteelRodMuJoCo_dataStatics.csv"
ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Orientation of the base: the files' rod lies on +x."""

HALF = Section.round(0.3, 0.8e-3, 200e9, 7870.0, 0.33, torsion_modes=3)

pytestmark = pytest.mark.skipif(
    not os.environ.get("TENDOND_REFERENCE_DATA") or not STATICS.exists(),
    reason="TENDOND_REFERENCE_DATA does not name a folder with others' data: see the page on the general rod",
)


def test_five_hundred_equilibria_under_wrenches_at_middle_and_tip() -> None:
    with STATICS.open(newline="") as file:
        table = [[float(one) for one in row[1:]] for row in list(csv.reader(file))[2:]]
    shapes = np.array(table).reshape(-1, 6, len(table[0]))
    errors = []
    for shape in shapes:
        gravity, middle, end, stations = shape[3:, 0], shape[:, 1], shape[:, 2], shape[3:, 3:]
        rod = StrainRod(Robot((HALF, HALF), gravity=(gravity[0], gravity[1], gravity[2]), base=ALONG_X))
        loads = rod.loads(wrenches=[(0.3, middle[3:], middle[:3]), (0.6, end[3:], end[:3])])
        errors.append(np.linalg.norm(rod.tip(rod.solve_static(loads))[0] - stations[:, -1]) / 0.6)
    assert len(errors) == 500
    assert np.median(errors) < 0.0005
    assert max(errors) < 0.005


@pytest.mark.parametrize(("time_step", "bound"), [(0.001, 0.002), (0.005, 0.0035)])
def test_releases_of_a_steel_rod_keep_to_the_others_path_for_ten_seconds(time_step: float, bound: float) -> None:
    means = []
    for number in range(1, 6):
        path = FOLDER / "sorosim_dynamics" / f"SpringSteelRodMuJoCo_{number}.txt"
        lines = [[float(one) for one in line.split()] for line in path.read_text().splitlines() if line.strip()]
        ratio, gravity, load, motion = lines[0][0], lines[0][-3:], lines[1], np.array(lines[2:])
        bending, torsion = HALF.bending_stiffness[0], HALF.torsion_stiffness
        section = replace(
            HALF, bending_damping=(ratio * bending, ratio * bending, ratio * torsion),
            axial_damping=ratio * HALF.axial_stiffness,
        )  # fmt: skip
        rod = StrainRod(
            Robot((section, section), gravity=(gravity[0], gravity[1], gravity[2]), base=ALONG_X), time_step
        )
        state = rod.solve_static(rod.loads(wrenches=[(0.3, load[4:7], load[1:4]), (0.6, load[10:13], load[7:10])]))
        free, every, errors = rod.loads(), round(0.005 / time_step), []
        for row in motion:
            errors.append(np.linalg.norm(rod.tip(state)[0] - row[10:13]) / 0.6)
            for _ in range(every):
                state = rod.step(state, free)
        means.append(np.mean(errors))
    assert np.mean(means) < bound
