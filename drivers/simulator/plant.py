"""Simulated robot: the rod of the controller's model with its own parameters, driven by commands."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.faults import Faults
from tendond.drivers.simulator.loads import SPREAD, HungWeight, impacts_at
from tendond.drivers.simulator.mocap import Mocap
from tendond.drivers.simulator.rods import GeneralPlantRod, PlantRod
from tendond.drivers.simulator.sensors import SimulatedSensors, Truth
from tendond.drivers.simulator.servo import SimulatedActuators
from tendond.model.rod.tip_body import ball_inertia
from tendond.schemas.config.rates import speed_line
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.faults import Fault
from tendond.schemas.messages import SensorReading, SimulatorTruth, TendonCommand, TendonState, TipPose

Array = NDArray[np.float64]

CUT_SLACK = 1.0
"""Slack of a cut tendon [m]."""


class Plant:
    """Rod that starts at rest, driven by tension, or by displacement through elastic tendons.

    A disarmed command is a servo without torque: the tendons are slack. Simulated servos apply the rig's limits of
    tension and displacement to every command, as real ones do.

    Args:
        config: configuration of the rig; `simulator` describes the plant.
        rod: by `rods.plant_rod`, with the plant's time step.

    Attributes:
        faults: faults that requests have caused.
        readings: of the sensors beside the camera, that arrive with the newest observation, by their names.
    """

    def __init__(self, config: RigConfig, rod: PlantRod) -> None:
        section = config.simulator
        self._section = section
        self._limits = config.limits
        self._rod = rod
        self._general = rod if isinstance(rod, GeneralPlantRod) else None
        slack = np.zeros(rod.parameters.tendon_count)
        self._command = slack
        self._by_displacement = False  # servos hold the tendons' displacement; else their tension is as commanded
        line = speed_line(config.servo, section.servo.voltage)
        self._servos = SimulatedActuators(section.servo, rod.time_step, slack, line)
        self.faults = Faults(len(slack), config.sensors)
        self._sensors = SimulatedSensors(config.sensors, section.seed, self.faults)
        self.readings: dict[str, SensorReading] = {}
        self._mocap = Mocap(section.mocap, section.seed, self.faults)
        straight = np.array([0.0, 0.0, rod.parameters.length])
        self._weight = HungWeight(section.weight, section.rod.base_gravity, straight)
        self._hung = 0.0  # mass that is part of the tip [kg]
        self._hang(self._weight.body(0.0))
        self._force = self._weight.force(0.0, rod.time_step)
        self._state: Any = rod.solve_static(slack, tip_force=self._force)
        self._before = self._state
        self._weight = HungWeight(section.weight, section.rod.base_gravity, rod.tip(self._state).position)
        self._pull = slack
        self._injected: tuple[str, ...] = ()  # loads and faults that acted during the last step
        self.seq = 0

    @property
    def tendon_count(self) -> int:
        """Number of tendons."""
        return len(self._command)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.seq * self._rod.time_step

    @property
    def state(self) -> Any:
        """State of the rod, as its steps return it."""
        return self._state

    def shape(self, points: int) -> Array:
        """Return points of the backbone from base to tip [m], shape (points, 3)."""
        return self._rod.curve(self._state, points)

    def let_go(self) -> None:
        """Torque off: the tendons are slack from the next step on."""
        self._by_displacement = False
        self._command = np.zeros(self.tendon_count)
        self._servos.stand(self._command)

    def step(self, command: TendonCommand | None) -> None:
        """Advance by one period under a new command, or under the last one when none came: servos hold.

        Raises:
            ConvergenceError: the plant has no solution; it stays where it was.
        """
        self.faults.time = self.time
        self._servos.stuck = self.faults.stuck
        if self.faults.reported:  # as the servos' driver does: all of them together
            self.let_go()
        elif command is not None:
            by_displacement = command.armed and self._section.drive == "displacement"
            if by_displacement and not self._by_displacement:
                self._servos.stand(self._rod.displacements(self._state, elastic=True))
            elif self._by_displacement and not by_displacement:
                self._servos.stand(np.zeros(self.tendon_count))
            self._by_displacement = by_displacement
            self._command = self._within_limits(command)
        self._force = self._weight.force(self.time, self._rod.time_step)
        more = self.faults.now(Fault.WEIGHT)
        self._hang(self._weight.body(self.time) + (0.0 if more is None else more.amount))
        push = np.zeros(3)
        impacts = impacts_at(self._section.impacts, self.time)
        if (impact := self.faults.now(Fault.IMPACT)) is not None:
            impacts.append((1.0 if impact.place is None else impact.place, np.array(impact.vector)))
        self._injected = self._acting(hung=self._weight.hangs(self.time), pushed=bool(impacts))
        for place, force in impacts:
            if place == 1.0:
                self._force = self._force + force
            else:  # of several at once along the rod, the last one's place counts for all
                push = push + force
                self._rod.spread_push(place, SPREAD)
        if self._by_displacement:
            mean, end = self._servos.follow_displacement(self._command, self._pull)
        else:
            mean, end = self._servos.follow_tension(self._command)
        for driven in (mean, end):
            driven[self.faults.cut] = -CUT_SLACK if self._by_displacement else 0.0
        loads: dict[str, Any] = {"tip_force": self._force, "push": push}
        loads["displacements" if self._by_displacement else "tensions"] = end
        if self._general is not None:
            loads["mean"] = mean
        self._before, self._state = self._state, self._rod.step(self._state, **loads)
        self._pull = self._state.tensions if self._by_displacement else end
        self._weight.swing(self.time, self._rod.tip(self._state).position, self._rod.time_step)
        self.seq += 1
        self.faults.time = self.time

    def _acting(self, *, hung: bool, pushed: bool) -> tuple[str, ...]:
        """Name the loads and faults that act now, each once."""
        loads = {Fault.WEIGHT.value: hung, Fault.IMPACT.value: pushed}
        return tuple(sorted(self.faults.active | {name for name, acts in loads.items() if acts}))

    def _hang(self, mass: float) -> None:
        """Fix a mass to the tip [kg], as a body that moves with it."""
        if mass != self._hung:
            self._rod.load_tip(mass, ball_inertia(mass))
            self._hung = mass

    def _within_limits(self, command: TendonCommand) -> Array:
        """Limit a command as the servos do: displacements [m] or tensions [N], shape (n,)."""
        limits = self._limits
        if self._by_displacement:
            return np.clip(command.displacement, limits.displacement_min, limits.displacement_max)
        return np.clip(command.tension, 0.0, limits.tension_max) if command.armed else np.zeros(self.tendon_count)

    def observe(self, stamp_ns: int) -> tuple[TipPose | None, TendonState, SimulatorTruth]:
        """Return the pose (none where none arrives now), the servos' report and the truth, captured at `stamp_ns`.

        `readings` are then those of the same time. Call it once a step.
        """
        tip = self._rod.tip(self._state)
        x, y, z = tip.position.tolist()
        vx, vy, vz = tip.velocity.tolist()
        fx, fy, fz = (self._force + self._hung * np.array(self._section.rod.base_gravity)).tolist()
        displacement = tuple(self._rod.displacements(self._state).tolist())
        ends = tuple(self._servos.ends.tolist()) if self._by_displacement else displacement
        tensions = self._state.tensions if self._general is None else self._general.mean_tensions(self._state)
        pull, fault = tuple(self._pull.tolist()), self.faults.reported
        state = TendonState(seq=self.seq, stamp_ns=stamp_ns, displacement=ends, tension=pull, fault=fault)
        truth = SimulatorTruth(
            seq=self.seq,
            stamp_ns=stamp_ns,
            position=(x, y, z),
            velocity=(vx, vy, vz),
            displacement=displacement,
            tension=tuple(tensions.tolist()),
            tip_force=(fx, fy, fz),
            injected=self._injected,
        )
        seen = Truth(self._rod, self._before, self._state, self._pull, self._section.rod.base_gravity)
        self.readings = self._sensors.read(seen, self.time, stamp_ns)
        return self._mocap.see(tip, self.time, stamp_ns), state, truth
