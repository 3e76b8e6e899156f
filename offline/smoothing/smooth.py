"""`tendond log smooth`: the smoother over all stretches of a log."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from tendond.daemon.control.estimation.estimator import configured_noise, estimator_with
from tendond.model.errors import ModelError
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.rods.general import GeneralRod
from tendond.model.strain.describe.configured import robot_from_section
from tendond.offline.logs.container import LogError
from tendond.offline.logs.log import LogFile
from tendond.offline.smoothing.passes import SmoothedStretch, smooth_stretch
from tendond.offline.smoothing.stretches import Stretch, stretches
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class SmoothedLog:
    """A log, its stretches that were smoothed, and what was left out of it, in words."""

    log: LogFile
    stretches: Sequence[SmoothedStretch]
    left_out: Sequence[str]


def smooth_log(log: LogFile, progress: Progress = lambda number, count, what: None) -> SmoothedLog:
    """Smooth all stretches of a log, each by itself.

    Args:
        log: the log. progress: is told in which stretch, of how many, what begins.

    Raises:
        LogError: it has no stretch with a pose, or the model has no solution in any.
    """
    estimator = estimator_of(log.config, str(log.path))
    wanted = stretches(log.config, log.records)
    if not wanted:
        probed = any(one.mode is Mode.PROBE for one in log.records)
        what = "armed, but its tendons were only probed" if probed else "never armed"
        raise LogError(f"{log.path}: the arm was {what}, so there is nothing to smooth; use another log")
    found: list[SmoothedStretch] = []
    left_out = []
    for number, stretch in enumerate(wanted):
        if not stretch.poses:
            left_out.append(f"{_named(stretch)}: no pose was admitted")
            continue
        try:
            found.append(smooth_stretch(estimator, stretch, partial(progress, number, len(wanted))))
        except ModelError as error:
            left_out.append(f"{_named(stretch)}: {error}")
    if not found:
        raise LogError(f"{log.path}: nothing could be smoothed: {'; '.join(left_out)}; use another log")
    return SmoothedLog(log, found, left_out)


def _named(stretch: Stretch) -> str:
    first, last = stretch.instants[0].tick, stretch.instants[-1].tick
    return f"cycles {first} to {last}"


def estimator_of(config: RigConfig, source: str) -> Estimator:
    """Return the estimator of a configuration on the general rod, whatever observer was in use.

    Its noise is the configured one: no loop has to keep a margin with it.

    Raises:
        LogError: this version of tendond cannot use it; `source`: the log.
    """
    try:
        rod = GeneralRod(robot_from_section(config.rod), config.loop.period)
    except ModelError as error:
        raise LogError(f"{source}: {error}; smooth it with the version of tendond that wrote it") from error
    return estimator_with(config, rod, configured_noise(config, rod))
