"""Fixtures of the replay's tests."""

from pathlib import Path

import pytest

from tendond.offline.logs.run import open_run
from tendond.offline.replay.variant import same_inputs
from tests.golden.scripts import FOLDER

NORMAL = FOLDER / "normal.mcap"


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of this version on this processor: the golden one's inputs run again."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    same_inputs(NORMAL, open_run(NORMAL).config, path, "")
    return path
