"""Scenarios of `tendond demo`, by name."""

from collections.abc import Callable
from pathlib import Path

from tendond.drivers.simulator.rods import plant_rod
from tendond.model.errors import ModelError
from tendond.offline.demo.chain import run_chain, run_wired_chain
from tendond.offline.demo.report import report
from tendond.offline.demo.spatial import run_spatial
from tendond.schemas.config.presets import PROFILES, WIRED
from tendond.schemas.config.rig import ConfigError, parse_config

HOLD_SECONDS = {"paper": 3.0, "rig": 5.0, "nasty": 9.0}
"""Time of tracking, by profile; the impacts of the nasty one fall within it."""

WIRED_HOLD_SECONDS = 6.0


def run_plane(out: Path, profile: str = "paper", *, lockstep: bool = False, plant: str | None = None) -> None:
    """Run the paper's experiment; log, figures and summary are in `out` afterwards.

    Args:
        out: folder. profile: by name. lockstep: see `run_chain`.
        plant: value of simulator.solver, so that the log has it; default: the profile's.

    Raises:
        TendondError: a process could not be started, or failed; or that plant is not this profile's robot.
        ModuleNotFoundError: plant 'mujoco', and it is not installed.
    """
    text = PROFILES[profile] if plant is None else _on_plant(profile, plant)
    run_chain(out, text, HOLD_SECONDS[profile], report, lockstep=lockstep)


def _on_plant(profile: str, plant: str) -> str:
    """Return a profile with another plant, which is built once here so that it is refused before anything starts."""
    line, text = f'[simulator]\nsolver = "{plant}"\n', PROFILES[profile]
    text = text.replace("[simulator]\n", line) if "[simulator]\n" in text else f"{text}\n{line}"
    config = parse_config(text, f"profile '{profile}'")
    try:
        plant_rod(config.simulator, config.simulator.period)
    except ModelError as error:
        raise ConfigError(f"--plant {plant}: profile '{profile}': {error}") from error
    return text


def run_wired(out: Path) -> None:
    """Run the same robot behind emulated servos and a simulated Tracker, through the real drivers.

    Raises:
        TendondError: a process could not be started, or failed.
    """
    run_wired_chain(out, WIRED, WIRED_HOLD_SECONDS, report)


SCENARIOS: dict[str, Callable[[Path], None]] = {"plane": run_plane, "wired": run_wired, "spatial": run_spatial}
