"""The general rod beside figures that others published: their files are read where they lie, and never copied.

opencr-mujoco/: github.com/ContinuumRoboticsLab/opencr-mujoco @17fff8b (MIT), data/reference/sorosim: equilibria and
releases of a rod by SoRoSim, under wrenches at its middle and its tip. soromox-tendon-driven/:
github.com/tud-phi/soromox @4f03054 (MIT), paper_results/secIVa_benchmarking_sequential_cpu: one motion of a rod with
two tendons, by SoRoMoX and by SoRoSim.
"""

import csv
import math
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendond import TendondError
from tendond.model.errors import ConvergenceError
from tendond.model.strain import Robot, Section, StrainRod, Tendon

Array = NDArray[np.float64]

VARIABLE = "TENDOND_REFERENCE_DATA"
SOURCES = (
    "opencr-mujoco/{sorosim_statics,sorosim_dynamics} from github.com/ContinuumRoboticsLab/opencr-mujoco, "
    "data/reference/sorosim; soromox-tendon-driven/{soromox,sorosim}.csv (columns t,x,y,z) from "
    "github.com/tud-phi/soromox, paper_results/secIVa_benchmarking_sequential_cpu"
)
ALONG_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
"""Orientation of the base: SoRoSim's rod lies on +x."""

STEEL = Section.round(0.3, 0.8e-3, 200e9, 7870.0, 0.33, torsion_modes=3)
TPU = Section.round(0.2, 5e-3, 70e6, 1200.0, 0.4, torsion_modes=3)
"""Half of SoRoSim's rods: wrenches act where the halves meet, and at the tip."""

MATERIALS = {"SpringSteel": STEEL, "TPU": TPU}
RELEASES = (1, 2, 3, 4, 5)


class ReferenceDataError(TendondError):
    """Others' data are not where they were said to be; the message says where to get them."""


def data_folder(given: str = "") -> Path:
    """Return the folder of others' data: `given`, or, where it is empty, what TENDOND_REFERENCE_DATA names.

    Raises:
        ReferenceDataError: there is no such folder, or it holds none of the data.
    """
    name = given or os.environ.get(VARIABLE, "")
    if not name:
        raise ReferenceDataError(f"no folder of reference data: name it, or set {VARIABLE}; it holds {SOURCES}")
    folder = Path(name)
    if not any((folder / one).is_dir() for one in ("opencr-mujoco", "soromox-tendon-driven")):
        raise ReferenceDataError(f"{folder}: holds no reference data: put there {SOURCES}")
    return folder


def statics_file(folder: Path, material: str) -> Path:
    """Path of SoRoSim's equilibria of a rod, 'SpringSteel' or 'TPU'."""
    return folder / "opencr-mujoco" / "sorosim_statics" / f"{material}RodMuJoCo_dataStatics.csv"


def release_file(folder: Path, number: int) -> Path:
    """Path of one of SoRoSim's releases of the steel rod."""
    return folder / "opencr-mujoco" / "sorosim_dynamics" / f"SpringSteelRodMuJoCo_{number}.txt"


def rollout_file(folder: Path, program: str) -> Path:
    """Path of the motion of the rod with two tendons, by 'soromox' or 'sorosim'."""
    return folder / "soromox-tendon-driven" / f"{program}.csv"


def equilibria(folder: Path, material: str) -> Array:
    """Return the distances of the tip from SoRoSim's equilibria, in parts of the length; NaN where none was found.

    Each shape of the file has six rows (Euler angles, positions): gravity, wrenches at middle and tip as moment and
    force, then stations.
    """
    with statics_file(folder, material).open(newline="", encoding="utf-8") as file:
        table = [[float(one) for one in row[1:]] for row in list(csv.reader(file))[2:]]
    half = MATERIALS[material]
    errors = []
    for shape in np.array(table).reshape(-1, 6, len(table[0])):
        gravity, middle, end, tip = shape[3:, 0], shape[:, 1], shape[:, 2], shape[3:, -1]
        rod = StrainRod(Robot((half, half), gravity=(gravity[0], gravity[1], gravity[2]), base=ALONG_X))
        loads = rod.loads(wrenches=[(half.length, middle[3:], middle[:3]), (2.0 * half.length, end[3:], end[:3])])
        try:
            found = rod.tip(rod.solve_static(loads))[0]
        except ConvergenceError:
            found = np.full(3, math.nan)
        errors.append(np.linalg.norm(found - tip) / (2.0 * half.length))
    return np.array(errors)


def release(folder: Path, number: int, time_step: float) -> Array:
    """Return the distances of the tip from SoRoSim's along 10 s of a release at 200 Hz, in parts of the length.

    Raises:
        ConvergenceError: a step of ours found no solution.
    """
    text = release_file(folder, number).read_text(encoding="utf-8")
    lines = [[float(one) for one in line.split()] for line in text.splitlines() if line.strip()]
    ratio, gravity, load, motion = lines[0][0], lines[0][-3:], lines[1], np.array(lines[2:])
    bending, torsion = STEEL.bending_stiffness[0], STEEL.torsion_stiffness
    half = replace(
        STEEL, bending_damping=(ratio * bending, ratio * bending, ratio * torsion),
        axial_damping=ratio * STEEL.axial_stiffness,
    )  # fmt: skip
    rod = StrainRod(Robot((half, half), gravity=(gravity[0], gravity[1], gravity[2]), base=ALONG_X), time_step)
    state = rod.solve_static(rod.loads(wrenches=[(0.3, load[4:7], load[1:4]), (0.6, load[10:13], load[7:10])]))
    free, every, errors = rod.loads(), round(0.005 / time_step), []
    for row in motion:
        errors.append(np.linalg.norm(rod.tip(state)[0] - row[10:13]) / 0.6)
        for _ in range(every):
            state = rod.step(state, free)
    return np.array(errors)


def two_tendons(folder: Path, time_step: float = 0.01) -> dict[str, float]:
    """Return mean distances of tips over 3 s [m]: ours to 'soromox', ours to 'sorosim', and 'between' the two.

    An upright soft rod under its own weight, which buckles as two tendons pull with 1 N from t = 0 on. Material damping
    eta = 1e4 Pa s: 3 eta I, eta J, 3 eta A. Tendons 20 mm off the axis, 90 degrees apart.

    Raises:
        ConvergenceError: a step of ours found no solution.
    """
    soromox, sorosim = (
        np.loadtxt(rollout_file(folder, name), delimiter=",", skiprows=1) for name in ("soromox", "sorosim")
    )
    eta, radius, length = 1e4, 0.03, 0.6
    area, second = math.pi * radius**2, math.pi * radius**4 / 4.0
    section = Section.round(
        length, radius, 1e6, 1000.0, 0.5, bending_damping=(3.0 * eta * second,) * 2 + (2.0 * eta * second,),
        axial_damping=3.0 * eta * area, stretch_modes=3, torsion_modes=3,
    )  # fmt: skip
    tendons = (Tendon(length, (-0.02, 0.0)), Tendon(length, (0.0, 0.02)))
    rod = StrainRod(Robot((section,), tendons, gravity=(0.0, 0.0, -9.81)), time_step)
    state, pulled, tips = rod.rest(), rod.loads([1.0, 1.0]), []
    every = round(0.01 / time_step)
    count = min(len(soromox), len(sorosim))
    for _ in range(count):
        tips.append(rod.tip(state)[0])
        for _ in range(every):
            state = rod.step(state, pulled)

    def distance(one: Array, other: Array) -> float:
        return float(np.mean(np.linalg.norm(one - other, axis=1)))

    theirs = soromox[:count, 1:4], sorosim[:count, 1:4]
    return {
        "soromox": distance(np.array(tips), theirs[0]),
        "sorosim": distance(np.array(tips), theirs[1]),
        "between": distance(*theirs),
    }
