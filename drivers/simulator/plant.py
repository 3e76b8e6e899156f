"""The simulated robot: the same rod as the controller's model, with parameters of its own, driven by commands."""

import numpy as np

from tendond.model.rod import Rod
from tendond.model.rod_state import RodState
from tendond.model.rotation import quaternion
from tendond.model.tip import Tip
from tendond.schemas.config import RigConfig
from tendond.schemas.messages import SimulatorTruth, TendonCommand, TendonState, TipPose


class Plant:
    """A rod at rest, then wherever the commands take it: by tension, or by displacement through elastic tendons.

    A disarmed command is a servo without torque: the tendons are slack.

    Args:
        config: of the rig; `simulator` describes the plant.
        rod: built from `config.simulator.rod`, with the plant's time step.
    """

    def __init__(self, config: RigConfig, rod: Rod) -> None:
        self._rod = rod
        gravity = config.simulator.rod.gravity
        mass = config.simulator.tip_mass
        self._tip_force = (mass * gravity[0], mass * gravity[1], mass * gravity[2])
        self._drive = config.simulator.drive
        self._wound = False  # servos hold the tendons' displacement; else their tension is as commanded
        self._command = np.zeros(rod.parameters.tendon_count)
        self._state: RodState = rod.solve_static(self._command, tip_force=self._tip_force)
        self.seq = 0

    @property
    def tendon_count(self) -> int:
        """Of the rod."""
        return len(self._command)

    def let_go(self) -> None:
        """Torque off: the tendons are slack from the next step on."""
        self._wound = False
        self._command = np.zeros(self.tendon_count)

    def step(self, command: TendonCommand | None) -> None:
        """One period under a new command, or under the last one when none came: servos hold.

        Raises:
            ConvergenceError: the plant has no solution; it stays where it was.
        """
        if command is not None:
            self._wound = command.armed and self._drive == "displacement"
            self._command = np.array(command.displacement) if self._wound else np.maximum(command.tension, 0.0)
        if self._wound:
            self._state = self._rod.step(self._state, displacements=self._command, tip_force=self._tip_force)
        else:
            self._state = self._rod.step(self._state, self._command, tip_force=self._tip_force)
        self.seq += 1

    def observe(self, stamp_ns: int) -> tuple[TipPose, TendonState, SimulatorTruth]:
        """What a motion-capture system and servos would report now, and the truth; `stamp_ns` is their capture time."""
        tip: Tip = self._rod.tip(self._state)
        x, y, z = tip.position.tolist()
        vx, vy, vz = tip.velocity.tolist()
        displacement = tuple(self._rod.displacements(self._state).tolist())
        tension = tuple(self._state.tensions.tolist())
        pose = TipPose(seq=self.seq, stamp_ns=stamp_ns, position=(x, y, z), orientation=quaternion(tip.rotation))
        state = TendonState(seq=self.seq, stamp_ns=stamp_ns, displacement=displacement, tension=tension)
        truth = SimulatorTruth(
            seq=self.seq,
            stamp_ns=stamp_ns,
            position=(x, y, z),
            velocity=(vx, vy, vz),
            displacement=displacement,
            tension=tension,
            tip_force=self._tip_force,
        )
        return pose, state, truth
