"""Results of a fit's evaluations on disk, so that an interrupted fit can be resumed."""

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class EvaluationCache:
    """Results of evaluations on disk: an interrupted fit repeats them at once.

    Args:
        folder: folder of the files; none: nothing is kept.
        settings: settings of the fit; results with other settings are ignored.
    """

    def __init__(self, folder: Path | None, settings: Mapping[str, object]) -> None:
        digest = hashlib.sha256(json.dumps(settings, sort_keys=True, default=str).encode()).hexdigest()[:16]
        self._folder = None if folder is None else folder / digest
        self.known = 0

    def get(self, kind: str, at: Array, make: Callable[[], Array]) -> Array:
        """Return an evaluation's result from the folder, or compute and keep it."""
        if self._folder is None:
            return make()
        path = self._folder / f"{kind}-{hashlib.sha256(at.tobytes()).hexdigest()[:24]}.npy"
        try:
            found = np.load(path, allow_pickle=False)
        except (OSError, ValueError):
            found = make()
            self._folder.mkdir(parents=True, exist_ok=True)
            draft = path.with_suffix(".part")
            with draft.open("wb") as stream:
                np.save(stream, found)
            os.replace(draft, path)
        else:
            self.known += 1
        return np.asarray(found)

    def forget(self) -> None:
        """Remove the files once the fit has its result."""
        if self._folder is not None and self._folder.is_dir():
            for file in self._folder.iterdir():
                file.unlink()
            self._folder.rmdir()
            with suppress(OSError):  # other fits' results
                self._folder.parent.rmdir()
