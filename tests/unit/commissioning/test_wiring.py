"""A short selection from the study of wrong wiring: each kind of mistake once in both chains, and a few right rigs."""

import json

import pytest

from tendond.offline.wiring.report import markdown, rows
from tendond.offline.wiring.study import CHAINS, RIGHT, Job, WiringOutcome, jobs, run_job
from tests.unit.cli.commands import tendond

LAWS = ("backstepping", "sliding_mode", "sensitivity")
ALL = list(jobs(LAWS, 0))


def first_of_each(chain: str) -> list[Job]:
    """One run of every kind, of changing laws."""
    from tendond.offline.wiring.study import mistakes_of

    chosen: dict[str, int] = {}
    for index, mistake in enumerate(mistakes_of(chain)):
        chosen.setdefault(mistake.group, index)
    return [Job(chain, LAWS[k % 3], index) for k, index in enumerate(chosen.values())]


@pytest.mark.parametrize("chain", CHAINS)
def test_each_kind_of_mistake_is_noticed_before_the_arm_moves_far(chain: str) -> None:
    outcomes = [run_job(job) for job in first_of_each(chain)]
    late = [one for one in outcomes if not one.in_time]
    assert not late, late
    assert len(outcomes) >= 19


@pytest.mark.parametrize("chain", CHAINS)
def test_no_right_rig_of_half_a_dozen_raises_an_alarm(chain: str) -> None:
    numbers = [number for number in range(12) if tuple(CHAINS)[number % 2] == chain]
    outcomes = [run_job(Job(chain, LAWS[number // 2 % 2], None, number)) for number in numbers]
    assert not [one for one in outcomes if one.noticed]


def test_every_order_and_sign_of_the_tendons_is_among_the_runs() -> None:
    assert sum(job.chain == "ideal" and job.law == "backstepping" for job in ALL) >= 24 * 16 - 1 + 70


def outcome(group: str, *, noticed: bool, moved: float) -> WiringOutcome:
    return WiringOutcome(group, "one", "backstepping", "ideal", noticed, "wiring: it is", 1.0, moved, 0.1)


def test_a_row_falls_short_by_what_is_missed_late_or_a_false_alarm() -> None:
    table = rows(
        [
            outcome("seen", noticed=True, moved=0.02),
            outcome("late", noticed=True, moved=0.2),
            outcome("missed", noticed=False, moved=0.0),
            outcome(RIGHT, noticed=False, moved=1.0),
        ]
    )
    assert [row.holds for row in table] == [True, False, False, True]
    assert not rows([outcome(RIGHT, noticed=True, moved=0.0)])[0].holds
    assert "| ideal | late | 1 | 0 | 1 | 1 | 1.0 | 20.0 % | 10.0 % |" in markdown(table)


def test_the_command_prints_rows_as_json_and_its_exit_status_tells(capsys: pytest.CaptureFixture[str]) -> None:
    result = tendond(
        capsys, "study", "wiring", "--row", "lengths in another unit", "--law", "backstepping", "--setups", "2",
        "--processes", "1", "--json",
    )  # fmt: skip
    found = json.loads(result.out)
    assert result.status == 0
    assert [(row["chain"], row["group"], row["runs"]) for row in found] == [
        ("ideal", "lengths in another unit", 2), ("wired", "lengths in another unit", 2), ("ideal", RIGHT, 1),
        ("wired", RIGHT, 1),
    ]  # fmt: skip
    assert all(row["holds"] for row in found)
