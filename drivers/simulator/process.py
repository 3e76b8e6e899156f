"""Process of the simulator: publishes poses, tendon states and the truth, subscribes to commands."""

import time
from collections.abc import Callable, Mapping

import zenoh

from tendond import TendondError
from tendond.bus.client import StoppedError
from tendond.bus.followed import FollowedController
from tendond.bus.identity import new_source
from tendond.bus.subscription import LOCKSTEP_POLL_SECONDS, Subscription
from tendond.drivers.host import await_controller
from tendond.drivers.simulator.faults import handle_faults, listen
from tendond.drivers.simulator.introduction import Introduction
from tendond.drivers.simulator.plant import Plant
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.keys import SIMULATOR_TRUTH, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key, sensor_topic
from tendond.schemas.messages import ENCODING, Message, SimulatorTruth, TendonCommand, TendonState, TipPose
from tendond.schemas.requests import ControlReply
from tendond.schemas.wire import encode

QUEUE = 8
WATCHDOG_SECONDS = 0.5
"""Time without a command after which the simulated servos switch off [s]."""

CAUGHT_UP = 50
"""Largest number of periods that are caught up after a delay of the process."""

LOCKSTEP_PATIENCE_SECONDS = 0.5
"""Time without a reply after which the last pose is published again [s]: the controller may have started later."""


Observation = tuple[TipPose | None, TendonState, SimulatorTruth]


class SimulatorError(TendondError):
    """Plant that cannot be simulated as asked."""


class Simulator:
    """A plant on the bus.

    Args:
        config: configuration of the rig.
        plant: plant at rest.
        stopped: true when the process is to end.
    """

    def __init__(self, config: RigConfig, plant: Plant, stopped: Callable[[], bool]) -> None:
        self._config = config
        self._plant = plant
        self._stopped = stopped
        self._source = new_source("simulator")
        self._followed = FollowedController()
        self._introduction = Introduction(config)
        self.unreadable = 0
        self._misfits = 0

    def run(self, *, lockstep: bool, cycles: int | None = None) -> None:
        """Simulate until stopped, or for so many cycles.

        Args:
            lockstep: wait for the command that replies to each pose, instead of for the clock.
            cycles: to simulate; none: no end.

        Raises:
            BusError: no controller.
            SimulatorError: lockstep with a motion capture that loses frames.
            ConvergenceError: the plant has no solution.
        """
        name = self._config.rig.name
        try:
            session = await_controller(self._config, self._stopped)
        except StoppedError:
            return
        if lockstep:
            self._source = "simulator-lockstep"  # a run repeats to the last byte
        with session:
            commands = Subscription(session, key(name, TENDON_COMMAND), TendonCommand, QUEUE)
            sensors = [sensor_topic(one.name) for one in self._config.sensors]
            publishers = {
                topic: session.declare_publisher(key(name, topic), encoding=ENCODING, express=True)
                for topic in (SIMULATOR_TRUTH, TENDON_STATE, *sensors, TIP_POSE)
            }
            faults = listen(session, name)
            period = self._config.simulator.period
            deadline, silent = time.monotonic(), 0.0
            while not self._stopped() and (cycles is None or self._plant.seq < cycles):
                handle_faults(faults, self._cause_in_lockstep if lockstep else self._plant.faults.cause)
                if lockstep:
                    self._plant.step(self._next_command(commands, publishers))
                else:
                    cut = self._plant.faults.now(Fault.SILENCE) is not None
                    observation = self._plant.observe(round(1e9 * deadline))  # its time, though it may be late
                    if not cut:
                        self._send(publishers, observation)
                    deadline += period
                    now = time.monotonic()
                    if now > deadline:  # late by more than a period: its poses are lost, but the arm has moved on
                        missed = int((now - deadline) / period) + 1
                        deadline += missed * period
                        for left in range(min(missed, CAUGHT_UP), 0, -1):
                            self._plant.step(None)
                            self._plant.observe(round(1e9 * (deadline - left * period)))
                    time.sleep(max(0.0, deadline - time.monotonic()))
                    received = self._received(commands)
                    if cut:
                        received = []
                    silent = 0.0 if received else silent + period
                    if silent > WATCHDOG_SECONDS:
                        self._plant.let_go()
                    self._plant.step(received[-1] if received else None)

    def _cause_in_lockstep(self, request: FaultRequest) -> ControlReply:
        """Refuse what leaves a cycle without its pose: both sides would wait for ever."""
        if request.fault in (Fault.DROPOUT, Fault.SILENCE):
            return ControlReply(
                done=False, message=f"{request.fault.value}: not in lockstep, where each cycle waits for its pose"
            )
        return self._plant.faults.cause(request)

    def _send(self, publishers: Mapping[str, zenoh.Publisher], observation: Observation) -> None:
        """The pose last: a controller that waits for it then finds all else there."""
        pose, state, truth = observation
        if two := self._followed.objection(time.monotonic()):
            state = state.model_copy(update={"fault": "; ".join(filter(None, (two, state.fault)))})
        truth = self._introduction.added_to(truth)
        messages: dict[str, Message | None] = {SIMULATOR_TRUTH: truth, TENDON_STATE: state}
        messages |= {sensor_topic(name): reading for name, reading in self._plant.readings.items()}
        messages[TIP_POSE] = pose
        for topic, message in messages.items():
            if message is not None:
                publishers[topic].put(encode(message.named(self._source)))

    def _received(self, commands: Subscription[TendonCommand]) -> list[TendonCommand]:
        """Take the commands that have come since the last call, oldest first."""
        received = []
        for command in commands:
            if len(command.tension) == len(command.displacement) == self._plant.tendon_count:
                if self._followed.admits(command, time.monotonic()):
                    received.append(command)
            else:
                self._misfits += 1
        self.unreadable = self._misfits + commands.unreadable.total()
        return received

    def _next_command(
        self, commands: Subscription[TendonCommand], publishers: Mapping[str, zenoh.Publisher]
    ) -> TendonCommand | None:
        """Publish a pose and wait for the command that replies to it; none when the process is to end.

        Stamps are simulated time, so that a run repeats to the last byte.
        """
        observation = self._plant.observe(round(self._plant.seq * self._config.simulator.period * 1e9))
        if observation[0] is None:
            raise SimulatorError(
                "simulator.mocap: no frame, but in lockstep each cycle waits for one; leave out period, jitter, dropout"
            )
        patience = 0.0
        while not self._stopped():
            for command in self._received(commands):
                if command.pose_seq == observation[0].seq:
                    return command
            if time.monotonic() > patience:
                self._send(publishers, observation)
                patience = time.monotonic() + LOCKSTEP_PATIENCE_SECONDS
            time.sleep(LOCKSTEP_POLL_SECONDS)
        return None
