"""Settings that decide the results of a run: two runs with the same settings have the same results."""

import json
from dataclasses import dataclass
from typing import Any

import tendond
from tendond.offline.source_hash import source_hash
from tendond.schemas.config.rig import RigConfig

SOURCES = (
    "model", "schemas", "drivers/simulator", "daemon/control", "offline/logs/metrics.py",
    "offline/robustness/alarms.py", "offline/robustness/points.py", "offline/robustness/evaluate.py",
    "offline/robustness/plants.py", "offline/robustness/unlike.py",
)  # fmt: skip
"""Modules of the package that a result depends on. A better figure does not make results stale."""


@dataclass(frozen=True)
class Settings:
    """Settings of a run.

    Attributes:
        points: name of the set. count: random points per law. seed: seed of all that is random.
        laws, feedbacks: names; no feedbacks: the set's own.
        config: the controller's configuration.
    """

    points: str
    count: int
    seed: int
    laws: tuple[str, ...]
    feedbacks: tuple[str, ...] | None
    config: RigConfig

    def as_json(self) -> dict[str, Any]:
        """Return the settings as in results file and summary, with version and hash of the code."""
        values = {
            "points": self.points,
            "count": self.count,
            "seed": self.seed,
            "laws": list(self.laws),
            "feedbacks": None if self.feedbacks is None else list(self.feedbacks),
            "version": tendond.__version__,
            "source": source_hash(SOURCES),
            "config": self.config.model_dump(mode="json"),
        }
        return dict(json.loads(json.dumps(values)))
