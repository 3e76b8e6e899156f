"""`tendond demo --scenario spatial`: the tip on a circle in space, without and with the drivers."""

import json
from pathlib import Path

import numpy as np
from rich.console import Console

from tendond.daemon.control.reference.spatial import SpatialReference
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.errors import DaemonError
from tendond.offline.demo.chain import run_chain, run_wired_chain
from tendond.offline.demo.report import without_figures
from tendond.offline.demo.truth import true_tips
from tendond.offline.logs.arrays import load
from tendond.offline.progress import working
from tendond.offline.trials.measure import TrialOutcome, outcome_of
from tendond.offline.trials.paths import Trial
from tendond.schemas.config.presets import SPACE, WIRED_SPACE
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode

CHAINS = {"ideal": SPACE, "rig": WIRED_SPACE}
REST_SECONDS = 1.0
"""Rest after the trajectory [s]."""


def run_spatial(out: Path) -> None:
    """Run both chains; a folder each, and `summary.json` and a figure of each in `out`.

    Raises:
        TendondError: a process could not be started, or failed.
    """
    found: dict[str, dict[str, object]] = {}

    def report(folder: Path, log: Path, console: Console) -> None:
        name = folder.name
        outcome = outcome_from_log(log)
        trial = Trial("circle 250 mm", {}, name == "rig")
        try:
            from tendond.offline.trials.figure import draw

            figure = str(draw(trial, outcome, out / f"{name}.png", CHAIN_WORDS[name]))
        except ModuleNotFoundError as error:
            figure = without_figures(error, log)
        found[name] = outcome.as_json()
        (out / "summary.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
        console.print(
            f"{name}: RMS {outcome.rms_mm:.2f} mm, worst {outcome.worst_mm:.2f} mm; "
            + "".join(f"{note}; " for note in outcome.notes)
            + f"figure {figure}",
            soft_wrap=True,
            highlight=False,
            markup=False,
        )

    for name, text in CHAINS.items():
        with working(f"{name}: planning the circle, through rests of the whole arm"):
            arrival = _trajectory(text).arrival
        chain = run_chain if name == "ideal" else run_wired_chain
        chain(out / name, text, arrival + REST_SECONDS, report)


CHAIN_WORDS = {
    "ideal": "through Zenoh, tensions as commanded",
    "rig": "through servo driver, emulated servos, Vicon driver, UDP",
}


def _trajectory(text: str) -> SpatialReference:
    trajectory = CycleSetup.from_config(parse_config(text, "scenario spatial")).selection.reference
    assert isinstance(trajectory, SpatialReference)
    return trajectory


def outcome_from_log(path: Path) -> TrialOutcome:
    """Measure the first tracking stretch in the log of a simulated run.

    Raises:
        DaemonError: there is no such stretch, or no truth of a simulator.
    """
    run = load(path)
    mode = [str(value) for value in run["mode"]]
    if Mode.TRACKING.value not in mode or "truth.position" not in run.names:
        raise DaemonError(f"{path}: contains no tracking of a simulated rod")
    first = mode.index(Mode.TRACKING.value)
    count = next((i for i, value in enumerate(mode[first:]) if value != Mode.TRACKING.value), len(mode) - first)
    part = slice(first, first + count)
    trajectory = CycleSetup.from_config(run.config).selection.reference
    assert isinstance(trajectory, SpatialReference)
    truth = true_tips(run, part)
    recorded = ~np.isnan(truth[:, 0])
    ticks = np.asarray(run["tick"][part], dtype=np.float64)
    return outcome_of(
        time=((ticks - ticks[0]) * run.config.loop.period)[recorded],
        tip=truth[recorded],
        reference=np.asarray(run["reference.position"][part])[recorded],
        tension=np.asarray(run["command.tension"][part])[recorded],
        limited=sum(bool(value) for value in run["limited"][part]),
        trajectory=trajectory,
        mode=mode[first + count - 1],
        reason=str(run["reason"][first + count - 1]),
        goal_mm=float("inf"),
    )
