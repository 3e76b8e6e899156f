"""Scenarios of `tendond demo`, by name."""

from collections.abc import Callable
from pathlib import Path

from tendond.offline.demo.chain import run_chain, run_wired_chain
from tendond.offline.demo.report import report
from tendond.offline.demo.spatial import run_spatial
from tendond.schemas.config.presets import PROFILES, WIRED

HOLD_SECONDS = {"paper": 3.0, "rig": 5.0, "nasty": 9.0}
"""Time of tracking, by profile; the impacts of the nasty one fall within it."""

WIRED_HOLD_SECONDS = 6.0


def run_plane(out: Path, profile: str = "paper", *, lockstep: bool = False) -> None:
    """Run the paper's experiment; log, figures and summary are in `out` afterwards. `lockstep`: see `run_chain`.

    Raises:
        TendondError: a process could not be started, or failed.
    """
    run_chain(out, PROFILES[profile], HOLD_SECONDS[profile], report, lockstep=lockstep)


def run_wired(out: Path) -> None:
    """Run the same robot behind emulated servos and a simulated Tracker, through the real drivers.

    Raises:
        TendondError: a process could not be started, or failed.
    """
    run_wired_chain(out, WIRED, WIRED_HOLD_SECONDS, report)


SCENARIOS: dict[str, Callable[[Path], None]] = {"plane": run_plane, "wired": run_wired, "spatial": run_spatial}
