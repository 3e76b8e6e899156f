"""A scripted peer: a plant on the bus whose poses and tendon states a test may alter, drop, repeat or replace."""

import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Self

import numpy as np
import zenoh

from tendond.drivers.simulator.plant import Plant
from tendond.model.errors import ConvergenceError
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.messages import TendonCommand, TendonState, TipPose
from tendond.schemas.wire import decode, encode

Outgoing = Iterable[TipPose | TendonState | bytes | None]
"""Messages, bytes as they are, None for a DELETE."""


class Peer:
    """Camera and servos in one thread, each period; what comes from the plant goes through `alter` first.

    Args:
        config: of the rig.
        session: of a client, which the peer does not close.
    """

    def __init__(self, config: RigConfig, session: zenoh.Session) -> None:
        self._config = config
        self._plant = Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))
        name = config.rig.name
        self._session = session
        self._keys = (key(name, TIP_POSE), key(name, TENDON_STATE))
        self._commands = session.declare_subscriber(key(name, TENDON_COMMAND), zenoh.handlers.FifoChannel(1000))
        self.heard: list[TendonCommand] = []
        self.rounds = 0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self.heal()

    def heal(self) -> None:
        """Everything is passed on as it is, from now on."""
        self.alter: Callable[[TipPose], Outgoing] = lambda pose: [pose]
        self.alter_state: Callable[[TendonState], Outgoing] = lambda state: [state]

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ending.set()
        self._thread.join()

    def _run(self) -> None:
        period = self._config.simulator.period
        deadline = time.monotonic()
        while not self._ending.is_set():
            pose, state, _ = self._plant.observe(time.monotonic_ns())
            self._publish(self._keys[1], self.alter_state(state))
            self._publish(self._keys[0], [] if pose is None else self.alter(pose))
            self.rounds += 1
            deadline += period
            time.sleep(max(0.0, deadline - time.monotonic()))
            while (sample := self._commands.try_recv()) is not None:
                self.heard.append(decode(TendonCommand, sample.payload.to_bytes()))
            command = self.heard[-1] if self.heard else None
            with suppress(ConvergenceError):  # a plant that is asked too much stays where it is
                self._plant.step(command)
                while time.monotonic() > deadline + period:  # held up: poses are lost, but the arm moves on
                    deadline += period
                    self._plant.step(command)
            deadline = max(deadline, time.monotonic() - period)

    def _publish(self, topic: str, messages: Outgoing) -> None:
        for message in messages:
            if message is None:
                self._session.delete(topic)
            else:
                payload = message if isinstance(message, bytes) else encode(message)
                self._session.put(topic, payload, congestion_control=zenoh.CongestionControl.BLOCK)

    def unsafe(self) -> list[str]:
        """Return what is wrong with the commands heard: of all of them, whatever a test has done."""
        limits, period = self._config.with_own_rates().limits, self._config.loop.period
        objections = []
        last: TendonCommand | None = None
        for command in self.heard:
            tension, displacement = np.array(command.tension), np.array(command.displacement)
            if not (np.isfinite(tension).all() and np.isfinite(displacement).all()):
                objections.append(f"{command.seq}: not finite")
            if (tension < 0.0).any() or (tension > limits.tension_max).any():
                objections.append(f"{command.seq}: tension {command.tension}")
            if (displacement < limits.displacement_min).any() or (displacement > limits.displacement_max).any():
                objections.append(f"{command.seq}: displacement {command.displacement}")
            if last is not None and last.armed and command.armed and command.seq == last.seq + 1:
                step = np.abs(displacement - np.array(last.displacement)).max()
                if step > limits.displacement_rate * period + 1e-9:
                    objections.append(f"{command.seq}: displacement changed by {step}")
            last = command
        return objections
