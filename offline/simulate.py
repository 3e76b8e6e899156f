"""Runs of the closed loop for notebooks: controller and simulated robot, cycle by cycle, faster than real time."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.errors import UsageError
from tendond.drivers.simulator.lockstep import without_probe
from tendond.offline.identification.excitation.dry_run import dry_run
from tendond.offline.identification.excitation.plan import KINDS, propose
from tendond.offline.identification.recordings.weights import WEIGHT_NOTE
from tendond.offline.logs.arrays import Arrays, load
from tendond.offline.replay.offline import record_lockstep
from tendond.schemas.config.rig import RigConfig, check_config, parse_config
from tendond.schemas.requests import ControlAction

REST_SECONDS = 0.1
"""Time at rest before the request to arm [s]."""

RELEASE_SECONDS = 1.0
"""Time after the request to stop [s]: with the default rate the tendons are slack before."""

Config = RigConfig | Mapping[str, Any] | str | Path


def simulate(config: Config, log: str | Path, seconds: float = 3.0) -> Arrays:
    """Simulate a run and return its log: at rest, armed, tracking, stopped. The same configuration gives the same log.

    Tendons are not probed: a simulated robot is wired as it is configured.

    Args:
        config: configuration of controller and simulator: a RigConfig, its tables as in TOML, or the path of a file.
        log: MCAP file to write; an existing one is replaced.
        seconds: time from the request to arm to the request to stop [s].

    Raises:
        TendondError: an invalid configuration, a model without solution, or a log that is not whole.
        UsageError: `seconds` is not positive.
        OSError: the log cannot be written.
    """
    if not seconds > 0.0:
        raise UsageError(f"seconds = {seconds}: must be > 0")
    rig, path = without_probe(_checked(config)), Path(log)
    period = rig.loop.period
    arm, stop = round(REST_SECONDS / period), round((REST_SECONDS + seconds) / period)
    setup = CycleSetup.from_config(rig)
    path.unlink(missing_ok=True)
    requests = {arm: ControlAction.ARM, stop: ControlAction.STOP}
    record_lockstep(setup, stop + round(RELEASE_SECONDS / period), requests, path)
    return load(path)


def simulate_excitation(
    config: Config, log: str | Path, parts: Sequence[str] = KINDS, reach: float = 1.0, weight: float = 0.0
) -> Arrays:
    """Simulate a run of `tendond identify run` and return its log.

    Args:
        config, log: as of `simulate`; a known weight on the tip is added to the simulated robot.
        parts: parts of the excitation, in their order: sway, steps, chirp.
        reach: fraction of the range that the limits allow, in (0, 1].
        weight: known mass fixed to the tip [kg]; the log says so.

    Raises:
        TendondError: as of `simulate`, or a plan that cannot be carried out.
        OSError: the log cannot be written.
    """
    rig, path = _checked(config), Path(log)
    if weight:
        simulator = {**rig.simulator.model_dump(), "weight": {"mass": weight}}
        rig = check_config({**rig.model_dump(), "simulator": simulator}, "weight")
    plan = propose(rig, tuple(parts), reach)
    path.unlink(missing_ok=True)
    dry_run(rig, plan, path, {WEIGHT_NOTE: str(weight)})
    return load(path)


def _checked(config: Config) -> RigConfig:
    if isinstance(config, RigConfig):
        return config
    if isinstance(config, Mapping):
        return check_config(dict(config), "the configuration")
    return parse_config(Path(config).read_text(encoding="utf-8"), str(config))
