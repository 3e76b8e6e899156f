"""Tasks and plants of the comparison; a row is a law on one of each. Further ones are further entries."""

from dataclasses import dataclass
from functools import cache
from typing import Any

from tendond.drivers.simulator.lockstep import STRAIGHT, Wires
from tendond.drivers.wired.rig import without_servos
from tendond.model.rods.selection import model_rod
from tendond.offline.drive.cases import CAMERA, CONFIGURED, EMULATED_DELAY, REAL
from tendond.offline.drive.measure import emulated_wires
from tendond.offline.robustness.unlike import load_factor, unlike
from tendond.offline.trials.sections import TENSION_MAX, loop_of_poses
from tendond.schemas.assumed_rig import FRICTION
from tendond.schemas.config.presets import RIG
from tendond.schemas.config.rig import RigConfig, check_config, parse_config
from tendond.schemas.config.robot import RodSection

SIZE = 0.5
"""Length of the robot that the tasks are given for [m]: others take them in proportion."""

UNIFORM: dict[str, dict[str, Any]] = {
    "circle 100 mm": {"kind": "circle", "radius": 0.1, "period": 4.0},
    "circle 250 mm": {"kind": "circle", "radius": 0.25, "period": 4.0},
    "circle 320 mm": {"kind": "circle", "radius": 0.32, "period": 4.0},
    "figure-eight": {"kind": "figure_eight", "radius": 0.3, "period": 4.0},
    "helix": {"kind": "helix", "radius": 0.3, "radius_end": 0.08, "period": 3.0, "laps": 3},
    "step to 200 mm": {"kind": "step", "across": 0.2, "branch": "below_135"},
    "paper's task": {"kind": "exponential", "across": 0.34, "branch": "above_135"},
}
"""[reference] of each, for a robot of one section, of `SIZE`."""

LOOP: dict[str, Any] = {"kind": "path", "duration": 6.0, "turned_max": 0.2}

SECTIONS: dict[str, dict[str, tuple[float, str]]] = {
    "rao-2021": {"path with directions": (0.12, "direction")},
    "franka-tdcr-v4": {"path with directions": (0.10, "direction"), "path with orientations": (0.10, "pose")},
}
"""Tasks of a robot of sections: bend of each section in `loop_of_poses`, and what of the pose is prescribed."""

TASKS = (*UNIFORM, *dict.fromkeys(name for tasks in SECTIONS.values() for name in tasks))
ROBOTS = ("paper", *SECTIONS)
"""Robots of one, two and three sections."""

PLANTS = ("matched", "unlike", "friction", "wired")
"""The model itself; 2 cycles of delay, 0.1 mm of noise, E -10 % and 20 g on the tip; tendon friction of 0.2 that is
not configured; the paper's robot behind emulated servos with profile, backlash, friction and a late noisy camera, all
configured, as `tendond study servo` has it."""

PLANAR = ("backstepping", "sliding_mode")
"""Laws that follow a reference in the bending plane only."""

REST = 1.0
"""Time that a reference without a trajectory proper is followed for at its target [s]."""


@dataclass(frozen=True)
class Case:
    """A law on a task and a plant. observer: kind of the estimator. robot: preset of [rod]. period: of the loop [s]."""

    law: str
    task: str
    plant: str
    observer: str = "force"
    robot: str = "paper"
    period: float = 0.01
    seed: int = 0

    def config(self) -> RigConfig:
        """Return controller and plant.

        Raises:
            ConfigError: they do not go together.
        """
        values = (parse_config(RIG, "profile 'rig'") if self.plant == "wired" else RigConfig()).model_dump()
        values["rod"] = RodSection(preset=self.robot).model_dump()
        values["control"] |= {"law": self.law, "solver": "general"}
        values["loop"]["period"] = self.period
        values["observer"]["kind"] = self.observer
        values["reference"] = self._reference()
        values["vicon"] = None
        if self.robot in SECTIONS:
            values["limits"]["tension_max"] = TENSION_MAX
        if self.plant == "wired":
            values["servo"] = {}
            values["rod"]["tendon_friction"] = FRICTION
            values["observer"] |= {**CONFIGURED, "command_delay": EMULATED_DELAY}
            values["simulator"] |= {"servo": dict(REAL), "seed": self.seed}
            values["simulator"]["mocap"] |= CAMERA
        else:
            values["servo"] = None
            values["simulator"] = self._simulator(values)
        return check_config(values, f"case '{self.law}, {self.task}, {self.plant}'")

    def _reference(self) -> dict[str, Any]:
        if self.robot in SECTIONS:
            return {**LOOP, "waypoints": _waypoints(self.robot, *SECTIONS[self.robot][self.task])}
        size = model_rod(check_config({"rod": {"preset": self.robot}}, self.robot)).parameters.length / SIZE
        lengths = ("radius", "radius_end", "across")
        return {name: size * one if name in lengths else one for name, one in UNIFORM[self.task].items()}

    def _simulator(self, values: dict[str, Any]) -> dict[str, Any]:
        plant = RodSection.model_validate(values["rod"])
        found: dict[str, Any] = {"period": self.period, "solver": "general", "seed": self.seed}
        if self.plant == "unlike":
            plant = unlike(plant, 0.9)
            mass = 0.02 * load_factor(model_rod(check_config({"rod": values["rod"]}, self.robot)).parameters)
            values["observer"]["delay"] = 2.0 * self.period
            found |= {"weight": {"mass": mass}, "mocap": {"noise": 1e-4, "latency": 2.0 * self.period}}
        if self.plant == "friction":
            found["servo"] = {"friction": 0.2}
        return {**found, "rod": plant.model_dump()}

    def wired(self, config: RigConfig) -> tuple[RigConfig, Wires]:
        """Return the configuration to run, and what is between controller and plant."""
        if self.plant != "wired":
            return config, STRAIGHT
        return without_servos(config), emulated_wires(config).wires

    @property
    def possible(self) -> bool:
        """False for a task of another robot, a law of the plane on a task in space, and wires of another robot."""
        if self.robot in SECTIONS:
            return self.task in SECTIONS[self.robot] and self.law not in PLANAR and self.plant != "wired"
        if self.task not in UNIFORM or (self.plant == "wired" and self.robot != "paper"):
            return False
        return self.law not in PLANAR or "across" in UNIFORM[self.task]


@cache
def _waypoints(robot: str, bend: float, counts: Any) -> list[tuple[float, ...]]:
    return loop_of_poses(robot, bend, counts)
