"""Recordings made without a controller: commands by hand, the fit's own rod, noise."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tendond.offline.identification.configured import nominal
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.simulation.servos import tendon_ends
from tendond.offline.identification.simulation.simulate import Simulation
from tendond.schemas.config.rig import RigConfig, check_config

CONFIG = check_config(
    {
        "rod": {"tendon_stiffness": 2e4},
        "limits": {"displacement_min": -0.08, "displacement_max": 0.08, "displacement_rate": 0.085},
    },
    "test",
)
TRUE = {
    **nominal(CONFIG), "E": 1.8e11, "rho": 18000.0, "Bbt": 0.007, "C": 0.12, "tendon_stiffness": 1.8e4, "delay": 0.012,
    "lag": 0.02,
}  # fmt: skip
NAMES = ("E", "rho", "Bbt", "C", "tendon_stiffness", "delay", "lag")
"""All parameters that these recordings identify."""

PERIOD, RATE = 0.01, 0.08
STEP = 0.00125
"""Time step, a quarter of the fit's own [s]."""


AIMS = (
    (0.01, 0.0), (0.02, 0.0), (0.03, 0.0), (0.015, 0.0), (0.0, 0.01), (0.0, 0.02), (0.015, 0.015), (-0.01, 0.01),
    (-0.02, 0.0), (-0.025, -0.01), (-0.01, -0.02), (0.0, -0.025), (0.015, -0.015), (0.03, -0.01), (0.01, 0.02),
    (0.0, 0.005), (0.02, 0.0),
)  # fmt: skip
POSES = [(x, y, -x - 0.001, -y - 0.001) for x, y in AIMS]
"""Displacements of the tendons at 17 rests, in space [m]."""


def commands(levels: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Displacements [m] and whether they are armed: rest, ramps between levels, let go; shapes (k, 4) and (k,)."""
    pieces = [np.zeros(40)]
    for start, end in zip([0.0, *levels], levels, strict=False):
        pieces += [np.linspace(start, end, max(2, round(abs(end - start) / RATE / PERIOD))), np.full(25, end)]
    pieces.append(np.full(60, 0.0))
    pulled = np.concatenate(pieces)
    armed = np.ones(len(pulled), dtype=bool)
    armed[:40] = armed[-60:] = False
    command = np.column_stack([pulled, np.full_like(pulled, -0.002), -pulled - 0.002, np.full_like(pulled, -0.002)])
    return command, armed


def pulls_and_waits(poses: Sequence[Sequence[float]], wait: float = 1.2) -> tuple[np.ndarray, np.ndarray]:
    """Displacements [m] and whether they are armed: the arm hangs, is pulled from pose to pose, and waits at each."""
    slack, held = [-0.002] * len(poses[0]), round(wait / PERIOD)
    pieces = [np.tile(slack, (held, 1))]
    for start, end in pairwise([slack, *poses]):
        steps = max(2, round(float(np.max(np.abs(np.subtract(end, start)))) / RATE / PERIOD))
        pieces += [np.linspace(start, end, steps), np.tile(end, (held, 1))]
    command = np.concatenate(pieces)
    armed = np.ones(len(command), dtype=bool)
    armed[:held] = False
    return command, armed


def recording(
    values: Mapping[str, float] = TRUE,
    *,
    noise: float = 1e-4,
    seed: int = 0,
    weight: float = 0.0,
    levels: tuple[float, ...] = (0.03, 0.012, 0.04),
    config: RigConfig = CONFIG,
    reports: bool = True,
    moved: tuple[np.ndarray, np.ndarray] | None = None,
    general: bool = False,
    step: float = STEP,
) -> Recording:
    """Simulate the recording of a rig with these parameters.

    Args:
        values: its parameters. noise: of the poses [m]. seed: of it. weight: on the tip [kg].
        levels: displacements of the first tendon [m]. config: what is believed. reports: whether the servos report.
        moved: displacements and whether they are armed instead of `levels`, see `commands`.
        general: whether the general rod is the rig, not the shooting rod. step: its time step [s].
    """
    command, armed = commands(list(levels)) if moved is None else moved
    times = np.asarray(PERIOD * np.arange(len(command)), dtype=np.float64)
    pose_times = times.copy()
    bare = Recording(
        path=Path(f"made-{seed}-{weight:g}.mcap"),
        config=config,
        weight=weight,
        period=PERIOD,
        times=times,
        armed=armed,
        command=command,
        report_times=times,
        reported=command,
        pulled=np.zeros_like(command),
        pose_times=pose_times,
        position=np.zeros((len(pose_times), 3)),
        noise=noise,
        cycles=len(times),
        hidden=0,
        limited=0.0,
        missed=0,
        fault="",
    )
    simulation = Simulation(bare, "command", step, general)
    reported = tendon_ends(simulation.recording, times, values["lag"], values["backlash"])
    motion = simulation.motion(values)
    tips = simulation.predicted_poses(motion, values["delay"])
    rows = np.minimum(
        np.searchsorted(simulation.step * np.arange(len(motion.tensions)), times), len(motion.tensions) - 1
    )
    noisy = tips + noise * np.random.default_rng(seed).standard_normal(tips.shape)
    made = replace(bare, reported=reported, position=noisy, pulled=motion.tensions[rows])
    return (
        made if reports else replace(made, report_times=np.zeros(0), reported=np.zeros((0, 4)), pulled=np.zeros((0, 4)))
    )
