"""What decides the results of a run: two runs with the same settings have the same results."""

import functools
import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tendond
from tendond.schemas.config.rig import RigConfig

SOURCES = ("model", "schemas", "drivers/simulator", "daemon/laws", "daemon/space", "daemon/*.py",
           "offline/logs/metrics.py", "offline/robustness/points.py", "offline/robustness/evaluate.py")  # fmt: skip
"""Of the package: what a result depends on. A better figure does not make results old."""


@functools.cache
def source_hash(sources: tuple[str, ...] = SOURCES) -> str:
    """Of the code that results depend on, 12 hexadecimal digits; `sources` are files and folders of the package."""
    root = Path(tendond.__path__[0])
    digest = hashlib.sha256()
    for name in sources:
        folder = root / name
        files = sorted(folder.rglob("*.py")) if folder.is_dir() else sorted(root.glob(name))
        for file in files:
            digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:12]


@dataclass(frozen=True)
class Settings:
    """Of a run.

    Attributes:
        points: name of the set. count: of random points per law. seed: of all that is random.
        laws, feedbacks: names; no feedbacks: the set's own.
        config: of the controller.
    """

    points: str
    count: int
    seed: int
    laws: tuple[str, ...]
    feedbacks: tuple[str, ...] | None
    config: RigConfig

    def as_json(self) -> dict[str, Any]:
        """As it stands in journal and summary, with version and hash of the code."""
        values = {
            "points": self.points,
            "count": self.count,
            "seed": self.seed,
            "laws": list(self.laws),
            "feedbacks": None if self.feedbacks is None else list(self.feedbacks),
            "version": tendond.__version__,
            "source": source_hash(),
            "config": self.config.model_dump(mode="json"),
        }
        return dict(json.loads(json.dumps(values)))
