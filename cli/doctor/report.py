"""The table of checks, and its results as text or JSON."""

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from tendond import TendondError, __version__
from tendond.cli.common import SYSTEM_LOGS, load_config
from tendond.cli.doctor import bus, camera, commissioning, files, machine, sensors, servos
from tendond.cli.doctor.check import Check, CheckOutcome, CheckResult, Rig, failed, passed
from tendond.daemon.control.laws import select_law
from tendond.daemon.errors import LawError, UsageError
from tendond.offline.progress import working
from tendond.schemas.config.rig import ConfigError, RigConfig

CHECKS: dict[str, Check] = {
    "priority": machine.priority,
    "memory": machine.memory,
    "preemption": machine.preemption,
    "idle states": machine.idle_states,
    "governor": machine.governor,
    "processor": machine.processor,
    "clock": machine.clock,
    "wall clock": machine.wall_clock,
    "wake-up": machine.wake_up,
    "kernels": files.kernels,
    "log space": files.log_space,
    "log speed": files.log_speed,
    "controller": bus.controller,
    "poses": bus.poses,
    "sensors": sensors.sensors,
    "rest": commissioning.rest,
    "pose sender": camera.sender,
    "base": camera.level,
    "tags": camera.tags,
    "servo driver": bus.driver,
    "servo port": servos.port,
    "latency": servos.latency,
    "servos": servos.servos,
    "calibration": files.calibration,
    "tendons": commissioning.probe,
}
"""Checks in the order in which they run; the configuration is checked before them."""

COLOURS = {CheckOutcome.PASS: "32", CheckOutcome.WARN: "33", CheckOutcome.FAIL: "1;31"}
SYSTEM_CONFIG = Path("/etc/tendond")


class FailedChecksError(TendondError):
    """Error of a rig with at least one failed check."""


def examine(
    config_file: Path | None, log_folder: Path | None, *, query_servos: bool, as_json: bool, probe: bool = False
) -> None:
    """Run every check and print the results; see `tendond doctor --help`.

    Raises:
        UsageError: the configuration is invalid, so that nothing else was checked.
        FailedChecksError: another check has failed.
    """
    config, result = _configuration(config_file)
    results = {"configuration": result}
    if not as_json:
        _show("configuration", result)
    if config is not None:
        rig = Rig(config, config_file, log_folder or _logs(config_file), query_servos, probe)
        for name, one in results_of(rig, quiet=as_json):
            results[name] = one
            if not as_json:
                _show(name, one)
    failures = [name for name, one in results.items() if one.outcome is CheckOutcome.FAIL]
    if as_json:
        print(_json(config, results))
    if config is None:
        raise UsageError("invalid configuration: nothing else was checked")
    if failures:
        raise FailedChecksError(f"{len(failures)} of {len(results)} checks failed: {', '.join(failures)}")


def results_of(rig: Rig, *, quiet: bool = False) -> Iterator[tuple[str, CheckResult]]:
    """Run the checks that apply, and yield their results; without progress if `quiet`."""
    for name, check in CHECKS.items():
        try:
            with working(f"checking: {name}", quiet=quiet):
                result = check(rig)
        except (OSError, ValueError) as error:  # an unexpected machine: the other checks continue
            result = failed(f"check failed: {type(error).__name__}: {error}", "check it by hand")
        if result is not None:
            yield name, result


def _configuration(file: Path | None) -> tuple[RigConfig | None, CheckResult]:
    """Load and check the configuration, the laws' parameters included; none if it is invalid."""
    try:
        config = load_config(file)
        select_law(config.control.law, config.control.laws)
    except (ConfigError, LawError) as error:
        return None, failed(
            "; ".join(str(error).splitlines()), "fix it: nothing starts with it, and nothing else is checked"
        )
    servos_there = "servos" if config.servo is not None else "no servos"
    camera = "motion capture" if config.cameras is not None else "no motion capture"
    return config, passed(
        f"{file or 'built-in'}: rig '{config.rig.name}', {camera}, {servos_there}; tendond {__version__}"
    )


def _logs(config_file: Path | None) -> Path:
    """Return the folder in which the controller with this configuration logs."""
    if config_file is not None and config_file.resolve().parent.parent == SYSTEM_CONFIG:
        return SYSTEM_LOGS / config_file.resolve().parent.name
    return Path(os.environ.get("LOGS_DIRECTORY", "log"))


def _show(name: str, result: CheckResult) -> None:
    word = result.outcome.value
    if sys.stdout.isatty() and "NO_COLOR" not in os.environ:
        word = f"\033[{COLOURS[result.outcome]}m{word}\033[0m"
    print(f"{word}  {name:14} {result.finding}", flush=True)
    if result.remedy:
        print(f"      {'':14} -> {result.remedy}", flush=True)


def _json(config: RigConfig | None, results: dict[str, CheckResult]) -> str:
    checks = [
        {"check": name, "outcome": one.outcome.value, "finding": one.finding, "remedy": one.remedy}
        for name, one in results.items()
    ]
    worst = max((one.outcome for one in results.values()), key=list(CheckOutcome).index)
    return json.dumps({"rig": config and config.rig.name, "outcome": worst.value, "checks": checks}, indent=2)
