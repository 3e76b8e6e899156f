"""Fixtures of the doctor's tests."""

from pathlib import Path

import pytest

from tests.unit.cli.computer import Computer


@pytest.fixture
def computer(tmp_path: Path) -> Computer:
    return Computer(tmp_path)
