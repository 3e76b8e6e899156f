"""Recordings that several tests fit, one simulation of each a module."""

import pytest

from tendond.offline.identification.recordings.recording import Recording
from tests.unit.identification.recordings import recording


@pytest.fixture(scope="module")
def free() -> Recording:
    return recording()


@pytest.fixture(scope="module")
def weighted() -> Recording:
    return recording(seed=1, weight=0.04, levels=(0.02, 0.01, 0.025))
