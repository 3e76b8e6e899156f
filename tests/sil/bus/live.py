"""A controller and a simulator as processes, shared by tests, each of which finds them idle."""

import time

import zenoh

from tendond.offline.logs.log import load
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction
from tests.sil.rig import PATIENCE_SECONDS, Rig


class Live:
    """Running rig.

    Attributes:
        rig: its files and processes. session: an operator's.
        controller, simulator: the processes.
    """

    def __init__(self, rig: Rig, session: zenoh.Session) -> None:
        self.rig, self.session = rig, session
        self.controller, self.simulator = rig.started["run"], rig.started["simulate"]

    def calm(self) -> None:
        """Stop, reset, and wait until the tendons are slack and the tip is measured."""
        assert self.controller.poll() is None
        assert self.simulator.poll() is None
        self.rig.ask(self.session, ControlAction.STOP)
        self.rig.until(self.session, lambda s: s.mode in (Mode.IDLE, Mode.FAULT) and s.tension == (0.0,) * 4)
        self.rig.ask(self.session, ControlAction.RESET)
        self.rig.until(self.session, lambda s: s.mode is Mode.IDLE and s.tip is not None)

    def records(self, first: int) -> list[CycleRecord]:
        """Return the log's records from a tick to the present one, once they are on the disk."""
        last = self.rig.status(self.session).tick
        deadline = time.monotonic() + PATIENCE_SECONDS
        while (records := load(self.rig.folder / "run.mcap").records)[-1].tick < last:
            assert time.monotonic() < deadline
            time.sleep(0.2)
        return [record for record in records if record.tick >= first]
