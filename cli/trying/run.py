"""`tendond try`: the configuration, its trial, and the exit status."""

from pathlib import Path

from tendond.cli.common import chosen_config
from tendond.cli.manual.config_text import config_toml
from tendond.cli.warm.progress import compile_with_progress
from tendond.daemon.errors import UsageError
from tendond.offline.kernels import parts_of
from tendond.offline.trying.run import run_trial, tracking_time
from tendond.offline.trying.task import trial
from tendond.schemas.config.machine import BusSection
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.config.rod.presets import PRESETS


def run_try(
    file: Path | None,
    profile: str | None,
    preset: str | None,
    *,
    target: str | None,
    time: float | None,
    out: Path | None,
) -> None:
    """Try a configuration; see `tendond try --help`.

    Raises:
        TendondError: the configuration or the target cannot be used, or the folder cannot be written.
        SystemExit: with 1, the tip does not rest at its target.
    """
    config, source = _chosen(file, profile, preset)
    place = None if target is None else _numbers(target)
    compile_with_progress(parts_of(config), len(config.rod.tendon_positions))
    made = trial(config, place)
    hold = tracking_time(made.config) if time is None else time
    name = file.stem if file is not None else profile or preset or "paper"
    text = config_toml(made.config.model_copy(update={"bus": BusSection()}), changed=True, comments=False)
    if not run_trial(text, [source, *made.remarks], hold, out or Path("out") / f"try-{name}"):
        raise SystemExit(1)


def _chosen(file: Path | None, profile: str | None, preset: str | None) -> tuple[RigConfig, str]:
    if preset is None:
        return chosen_config(file, profile)
    if file is not None or profile is not None:
        raise ConfigError(f"--preset {preset}: give it, a file, or --profile: one of them")
    if preset not in PRESETS:
        raise ConfigError(f"unknown preset '{preset}': choose one of {', '.join(PRESETS)}")
    return check_config({"rod": {"preset": preset}}, f"preset '{preset}'"), f"preset '{preset}'"


def _numbers(text: str) -> tuple[float, ...]:
    """Read the target: one to three numbers with commas between.

    Raises:
        UsageError: it is something else.
    """
    try:
        found = tuple(float(one) for one in text.split(","))
    except ValueError:
        found = ()
    if not 1 <= len(found) <= 3:
        raise UsageError(f"--target '{text}': give x; x,z; or x,y,z, in metres, for instance 0.05 or 0.05,0.19")
    return found
