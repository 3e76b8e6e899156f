"""`tendond try`: the configuration, its trial, and the exit status."""

import re
from pathlib import Path

from tendond.cli.common import chosen_config
from tendond.cli.manual.config_text import config_toml
from tendond.cli.warm.progress import compile_with_progress
from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.files import free_folder
from tendond.offline.kernels import parts_of
from tendond.offline.trying.run import LOG, run_trial, tracking_time
from tendond.offline.trying.task import trial
from tendond.schemas.config.machine import BusSection
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.config.rod.presets import PRESETS
from tendond.schemas.errors.explain import choose


def run_try(
    file: Path | None,
    profile: str | None,
    preset: str | None,
    *,
    target: str | None,
    time: float | None,
    out: Path | None,
    force: bool = False,
) -> None:
    """Try a configuration; see `tendond try --help`.

    Raises:
        TendondError: the configuration or the target cannot be used, or the folder cannot be written.
        SystemExit: with 1, the tip does not rest at its target.
    """
    config, source = _chosen(file, profile, preset)
    name = file.stem if file is not None else profile or preset or "paper"
    folder = trial_folder(out, name, force=force)
    place = None if target is None else _numbers(target)
    compile_with_progress(parts_of(config), len(config.rod.tendon_positions))
    made = trial(config, place)
    hold = tracking_time(made.config) if time is None else time
    text = config_toml(made.config.model_copy(update={"bus": BusSection()}), changed=True, comments=False)
    if not run_trial(text, [source, *made.remarks], hold, folder):
        raise SystemExit(1)


def trial_folder(out: Path | None, name: str, *, force: bool) -> Path:
    """Return the folder of a trial, one that holds no other unless that is to be replaced.

    Args:
        out: that was named; none: out/try-NAME, with a number where that exists.
        name: of what is tried. force: replace.

    Raises:
        DaemonError: the folder that was named has a trial.
    """
    if out is None:
        usual = Path("out") / f"try-{name}"
        return usual if force else free_folder(usual)
    if not force and (out / LOG).exists():
        raise DaemonError(f"{out / LOG}: a trial is there already; --force replaces it, --out takes another folder")
    return out


def _chosen(file: Path | None, profile: str | None, preset: str | None) -> tuple[RigConfig, str]:
    if preset is None:
        return chosen_config(file, profile)
    if file is not None or profile is not None:
        raise ConfigError(f"--preset {preset}: give it, a file, or --profile: one of them")
    if preset not in PRESETS:
        raise ConfigError(f"unknown preset '{preset}': {choose(preset, PRESETS)}")
    return check_config({"rod": {"preset": preset}}, f"preset '{preset}'"), f"preset '{preset}'"


def _numbers(text: str) -> tuple[float, ...]:
    """Read the target: one to three numbers with commas between.

    Raises:
        UsageError: it is something else.
    """
    if re.fullmatch(r"\s*[-+]?0,\d+\s*", text):
        raise UsageError(
            f"--target '{text}': a decimal has a point: {text.replace(',', '.')}; commas are between numbers"
        )
    try:
        found = tuple(float(one) for one in text.split(","))
    except ValueError:
        found = ()
    if not 1 <= len(found) <= 3:
        raise UsageError(f"--target '{text}': give x; x,z; or x,y,z, in metres, for instance 0.05 or 0.05,0.19")
    return found
