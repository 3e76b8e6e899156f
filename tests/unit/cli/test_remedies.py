"""A fault names the command that clears it wherever it is shown; a refusal is a sentence."""

from pathlib import Path

import pytest
from rich.console import Console

from tendond.cli.rig.operator import remedy, status_table
from tendond.cli.watch.screen import frame, line
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.remedies import SENTENCES, clearing, sentence
from tests.unit.cli.commands import tendond
from tests.unit.cli.test_unusable_files import FAULTS, NORMAL
from tests.unit.cli.test_watch import left_column, status, watched

SERVOS = check_config({"servo": {}}, "test")


def test_a_fault_of_the_servos_names_both_resets() -> None:
    assert clearing("overrun: 3 deadlines missed in a row") == "fix the cause, then 'tendond reset'"
    assert clearing("tendons: servo 2: overload", " -c rig.toml", has_servos=True) == (
        "fix the cause, then 'tendond servo reset -c rig.toml' and 'tendond reset -c rig.toml'"
    )
    assert clearing("tendons: servo 2: overload") == "fix the cause, then 'tendond reset'"


def test_the_status_says_how_its_fault_is_cleared() -> None:
    config = Path("my rig.toml")
    bad = status(Mode.FAULT, "tendons: servo 2: overload")
    assert remedy(status(), RigConfig(), config) == ""
    console = Console(width=200, record=True)
    console.print(status_table(bad, remedy(bad, SERVOS, config)))
    text = console.export_text()
    assert "'tendond servo reset --config 'my rig.toml'' and 'tendond reset --config 'my rig.toml''" in text


@pytest.mark.parametrize("option", ["", " --config rig.toml"])
def test_the_live_view_says_how_its_fault_is_cleared(option: str) -> None:
    snapshot = watched(mode=Mode.FAULT, reason="pose stale: none accepted for 0.2 s")
    words = f"fix the cause, then 'tendond reset{option}'"
    assert words in line(snapshot, RigConfig(), 2.0, option)
    shown = frame(snapshot, RigConfig(), 2.0, 80, 24, option).plain
    assert words in " ".join(" ".join(row[:43] for row in shown.splitlines()).split())
    assert "fix the cause" not in left_column(watched())


@pytest.mark.parametrize(
    ("said", "mode", "shown"),
    [
        ("not armed: already probe", Mode.PROBE, "not armed: the tendons are being probed; 'tendond stop' ends it"),
        ("not armed: already tracking", Mode.TRACKING, "not armed: the arm is tracking; 'tendond stop' ends it"),
        (
            "not armed: already releasing",
            Mode.RELEASING,
            "not armed: the tendons are being released; arm again once the rig is idle",
        ),
        ("not armed: in fault (x); reset first", Mode.FAULT, "not armed: in fault (x): CLEAR"),
        ("not changed: fault; reset first", Mode.FAULT, "not changed: fault: CLEAR"),
        (
            "in fault: the tendons are released already",
            Mode.FAULT,
            "in fault: the tendons are released already: CLEAR",
        ),
        (
            "not changed: tracking; stop first",
            Mode.TRACKING,
            "not changed: the arm is tracking; run 'tendond stop' first",
        ),
        ("nothing to stop: idle", Mode.IDLE, "nothing to stop: the rig is idle"),
        ("nothing to reset: idle", Mode.IDLE, "nothing to reset: the rig is idle"),
        ("stopped: releasing the tendons", Mode.RELEASING, "stopped: releasing the tendons"),
        ("not armed: no pose of the tip has arrived yet", Mode.IDLE, "not armed: no pose of the tip has arrived yet"),
    ],
)
def test_a_reply_becomes_a_sentence_with_the_command_that_helps(said: str, mode: Mode, shown: str) -> None:
    assert sentence(said, mode, "CLEAR" if mode is Mode.FAULT else "") == shown


def test_every_mode_has_a_sentence() -> None:
    assert set(SENTENCES) == set(Mode)


def test_a_logs_account_and_report_say_how_its_fault_is_cleared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "fix the cause, then 'tendond reset'"
    assert f"to clear it: {words}" in tendond(capsys, "log", "info", str(FAULTS)).out
    assert tendond(capsys, "log", "report", str(FAULTS), "--out", str(tmp_path / "run.html")).status == 0
    assert words.replace("'", "&#x27;") in (tmp_path / "run.html").read_text()
    assert "to clear it" not in tendond(capsys, "log", "info", str(NORMAL)).out
