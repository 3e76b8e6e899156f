"""Tasks and plants of the comparison; a row is a law on one of each. Further ones are further entries."""

from dataclasses import dataclass
from typing import Any

from tendond.model.rods.selection import model_rod
from tendond.offline.robustness.unlike import load_factor, unlike
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.robot import RodSection

SIZE = 0.5
"""Length of the robot that the tasks are given for [m]: others take them in proportion."""

TASKS: dict[str, dict[str, Any]] = {
    "circle 100 mm": {"kind": "circle", "radius": 0.1, "period": 4.0},
    "circle 250 mm": {"kind": "circle", "radius": 0.25, "period": 4.0},
    "circle 320 mm": {"kind": "circle", "radius": 0.32, "period": 4.0},
    "figure-eight": {"kind": "figure_eight", "radius": 0.3, "period": 4.0},
    "helix": {"kind": "helix", "radius": 0.3, "radius_end": 0.08, "period": 3.0, "laps": 3},
    "step to 200 mm": {"kind": "step", "across": 0.2, "branch": "below_135"},
    "paper's task": {"kind": "exponential", "across": 0.34, "branch": "above_135"},
}
"""[reference] of each, on a robot of `SIZE`."""

PLANTS = ("matched", "unlike", "friction")
"""The model itself; 2 cycles of delay, 0.1 mm of noise, E -10 % and 20 g on the tip; tendon friction of 0.2."""

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
        values = RigConfig().model_dump()
        values["rod"] = RodSection(preset=self.robot).model_dump()
        size = model_rod(check_config({"rod": values["rod"]}, self.robot)).parameters.length / SIZE
        lengths = ("radius", "radius_end", "across")
        values["reference"] = {name: size * one if name in lengths else one for name, one in TASKS[self.task].items()}
        values["control"] |= {"law": self.law, "solver": "general"}
        values["loop"]["period"] = self.period
        values["observer"]["kind"] = self.observer
        values["servo"] = values["vicon"] = None
        plant = RodSection.model_validate(values["rod"])
        values["simulator"] = {"period": self.period, "solver": "general", "seed": self.seed}
        if self.plant == "unlike":
            plant = unlike(plant, 0.9)
            mass = 0.02 * load_factor(model_rod(check_config({"rod": values["rod"]}, self.robot)).parameters)
            values["observer"]["delay"] = 2.0 * self.period
            mocap = {"noise": 1e-4, "latency": 2.0 * self.period}
            values["simulator"] |= {"weight": {"mass": mass}, "mocap": mocap}
        if self.plant == "friction":
            values["simulator"]["servo"] = {"friction": 0.2}
        values["simulator"]["rod"] = plant.model_dump()
        return check_config(values, f"case '{self.law}, {self.task}, {self.plant}'")

    @property
    def possible(self) -> bool:
        """False for a law of the plane on a task in space."""
        return self.law not in PLANAR or "across" in TASKS[self.task]
