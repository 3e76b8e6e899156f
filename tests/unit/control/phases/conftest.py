"""The bench that the tests of the phases share."""

from typing import Any

import pytest

from tests.unit.control.phases.scripted_rod import Bench, MakeBench, make_bench


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> MakeBench:
    """Make benches, by configuration."""

    def made(text: str = "", **options: Any) -> Bench:
        return make_bench(monkeypatch, text, **options)

    return made
