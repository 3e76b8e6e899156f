"""Costs of a loop and a bus on this machine without a controller: the bare counterparts of `tendond bench loop`.

As a program, `python -m tendond.offline.bench.bare bare SECONDS PERIOD` sleeps to absolute deadlines and prints how
late it woke; `echo ENDPOINT PERIOD` sends each message on `bare/pose` back on `bare/command`, at once or, with a
period, at the next tick.
"""

import json
import sys
import time
from dataclasses import asdict, dataclass

import numpy as np
import zenoh

from tendond.bus.subscription import LOCKSTEP_POLL_SECONDS
from tendond.daemon.runtime.realtime import be_prompt, become_punctual
from tendond.schemas.config.control import LoopSection


@dataclass(frozen=True)
class Quantiles:
    """Median and upper quantiles of a duration [us]."""

    median: float
    p99: float
    p999: float

    @staticmethod
    def of(microseconds: list[float]) -> "Quantiles":
        """Compute the quantiles of a sample, which must not be empty."""
        median, p99, p999 = np.percentile(microseconds, [50.0, 99.0, 99.9]).tolist()
        return Quantiles(median, p99, p999)

    def over(self, other: "Quantiles") -> "Quantiles":
        """Return the ratios of two sets of quantiles."""
        return Quantiles(self.median / other.median, self.p99 / other.p99, self.p999 / other.p999)

    def as_json(self) -> dict[str, float]:
        """Return the quantiles by name."""
        return asdict(self)


def bare_loop(seconds: float, period: float) -> tuple[list[float], int]:
    """Wake at absolute deadlines and do nothing: lateness of each wake-up [us], and deadlines missed."""
    late, missed = [], 0
    deadline = time.monotonic()
    for _ in range(int(seconds / period)):
        deadline += period
        now = time.monotonic()
        if now >= deadline:
            skipped = int((now - deadline) / period) + 1
            missed += skipped
            deadline += skipped * period
        time.sleep(max(0.0, deadline - now))
        late.append((time.monotonic() - deadline) * 1e6)
    return late, missed


def echo(endpoint: str, period: float) -> None:
    """Send back what comes until killed; with a period, only at its ticks, the newest alone."""
    settings = zenoh.Config()
    settings.insert_json5("mode", '"peer"')
    settings.insert_json5("listen/endpoints", json.dumps([endpoint]))
    settings.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(settings) as session:
        poses = session.declare_subscriber("bare/pose", zenoh.handlers.RingChannel(1))
        commands = session.declare_publisher("bare/command", priority=zenoh.Priority.REAL_TIME, express=True)
        deadline = time.monotonic()
        while True:
            if period:
                deadline = max(deadline + period, time.monotonic())
                time.sleep(max(0.0, deadline - time.monotonic()))
            else:
                time.sleep(LOCKSTEP_POLL_SECONDS)
            if (sample := poses.try_recv()) is not None:
                commands.put(sample.payload.to_bytes())


def main() -> None:
    """See the module."""
    what, first, period = sys.argv[1], sys.argv[2], float(sys.argv[3])
    if what == "echo":
        if period:
            become_punctual(LoopSection())
        else:
            be_prompt()
        echo(first, period)
    else:
        become_punctual(LoopSection())
        late, missed = bare_loop(float(first), period)
        print(json.dumps({"late_us": late, "missed": missed}))


if __name__ == "__main__":
    main()
