"""The filter in the status, the live view and the terminal."""

import numpy as np
import pytest
from rich.console import Console

from tendond.cli.rig.operator import status_table
from tendond.cli.watch.screen import frame, line
from tendond.daemon.control.state import initial_state
from tendond.daemon.runtime.status import filter_health, status_of
from tendond.schemas.health import CONSISTENCY_MARKED, FilterHealth
from tendond.schemas.messages import Status
from tests.unit.cli.test_watch import CONFIG, status, watched
from tests.unit.estimation.shown.conftest import Filtered
from tests.unit.offline.records import cycle_record

HEALTH = FilterHealth(
    force=0.304, force_deviation=0.026, tip_bound=0.00247, stiffness=1.01, stiffness_deviation=0.007, consistency=0.9
)
TOLD = "force 0.30±0.03 N, consistency 0.9, tip (95 %) within 2.5 mm, stiffness 1.01±0.01"


def table(one: Status) -> str:
    console = Console(width=200)
    with console.capture() as shown:
        console.print(status_table(one))
    return shown.get()


def test_status_and_live_view_show_the_filter_where_there_is_one() -> None:
    with_filter = status().model_copy(update={"filter": HEALTH, "tension_estimate": (1.0,) * 4})
    snapshot = watched()
    for one, there in ((status(), False), (with_filter, True)):
        snapshot.add(one, 1.99)
        assert (TOLD in table(one)) == there
        assert (f"filter: {TOLD}" in line(snapshot, CONFIG, 2.0)) == there
        text = frame(snapshot, CONFIG, 2.0, 80, 24).plain
        for part in ("force    0.30±0.03 N, consistency 0.9", "tip 95 % 2.5 mm, stiffness 1.01±0.01"):
            assert (part in text) == there
        assert "entries dropped" in text
        assert ("filter" in one.model_dump_json()) == there
        sent = one.model_copy(update={"tension_estimate": (1.0,) * 4})
        assert Status.model_validate_json(sent.model_dump_json()) == sent


@pytest.mark.parametrize(("consistency", "marked"), [(CONSISTENCY_MARKED, False), (CONSISTENCY_MARKED + 0.1, True)])
def test_a_filter_that_is_less_sure_than_it_claims_is_marked(consistency: float, marked: bool) -> None:
    health = HEALTH.model_copy(update={"consistency": consistency})
    assert (f"consistency {consistency:.1f} > 4" in health.in_words) == marked
    snapshot = watched()
    snapshot.add(status().model_copy(update={"filter": health}), 1.99)
    shown = frame(snapshot, CONFIG, 2.0, 80, 24)
    at = shown.plain.index(health.force_in_words)
    assert any(span.style == "yellow" and span.start <= at < span.end for span in shown.spans) == marked


def test_the_health_is_that_of_the_record(filtered: Filtered) -> None:
    record = filtered.records[-1]
    known, health = record.observer.filter, filter_health(record.observer, record.model)
    assert known is not None
    assert health is not None
    assert health.force == pytest.approx(np.linalg.norm(record.observer.force))
    xx, _, _, yy, _, zz = known.tip_covariance
    assert np.sqrt(7.8 * max(xx, yy, zz)) < health.tip_bound < np.sqrt(7.83 * (xx + yy + zz))
    xx, _, _, yy, _, zz = known.force_covariance
    assert 0.0 < health.force_deviation < np.sqrt(xx + yy + zz)
    assert (health.stiffness, health.consistency) == (known.stiffness, known.consistency)
    assert (health.tip, health.tip_orientation) == (record.model.position, record.model.orientation)
    sent = status_of(filtered.setup, initial_state(filtered.setup), record, 1, status().loop)
    assert sent.filter == health


def test_an_observer_without_a_filter_has_no_health() -> None:
    record = cycle_record(1)
    assert filter_health(record.observer, record.model) is None
