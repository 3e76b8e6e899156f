"""What a cycle takes is measured while the law tracks, and remarked on where it is too much of the period."""

from typing import Any

import pytest

from tendond.offline import cycle_time
from tendond.schemas.config.rig import check_config

ARM: dict[str, Any] = {
    "rod": {"damping_ratio": 0.02},
    "reference": {"across": 0.2},
    "control": {"law": "sensitivity"},
    "pretension": {"duration": 0.1},
}


def test_a_cycle_takes_some_of_the_period() -> None:
    found = cycle_time.cycle_time(check_config(ARM, "arm"))
    assert found is not None
    assert found > 0.0


@pytest.mark.parametrize(("seconds", "remarked"), [(4e-3, False), (6e-3, True), (None, False)])
def test_more_than_half_of_the_period_is_remarked(
    seconds: float | None, remarked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cycle_time, "cycle_time", lambda config: seconds)
    said, remark = cycle_time.cycle_lines(check_config(ARM, "arm"))
    assert ("deadlines will be missed" in remark) is remarked
    assert said == ("" if seconds is None else f"a cycle takes {1e3 * seconds:g} ms of 10 ms on this machine")
