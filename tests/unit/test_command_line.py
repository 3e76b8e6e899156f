"""Every command: help with an example, bad usage in a few lines, no traceback for a mistake, no colours where piped."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from tendond.daemon.cli.app import app
from tests.golden.scripts import FOLDER
from tests.unit.commands import tendond

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"
TENDOND = [sys.executable, "-m", "tendond.daemon.cli"]
HEAVY = ("matplotlib", "mcap", "numba", "numpy", "plotly", "pydantic", "rich", "scipy", "zenoh")


def walk(command: Any, name: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command and group, by its words."""
    if name:
        yield name, command
    for word, inner in getattr(command, "commands", {}).items():
        yield from walk(inner, (*name, word))


COMMANDS = dict(walk(get_command(app)))
RUNNABLE = {
    name: one for name, one in COMMANDS.items() if not getattr(one, "commands", {}) or one.invoke_without_command
}
REQUIRED = {
    "law": ["backstepping"],
    "reference": ["across=0.3"],
    "inject": ["noise"],
    "servo setup": ["1"],
    "simulate": ["--wired"],
}
LOG_COMMANDS = [("log", "info"), ("log", "recover"), ("log", "export"), ("replay",), ("compare",), ("plot",),
                ("report",), ("view",)]  # fmt: skip


def few_lines(said: str) -> bool:
    """What a person is told: something, not much, and not where in the program it happened."""
    lines = said.strip().splitlines()
    return 1 <= len(lines) <= 6 and "Traceback" not in said


def test_there_are_commands_to_walk() -> None:
    assert len(COMMANDS) > 30
    assert ("config", "check") in COMMANDS
    assert ("log", "info") in COMMANDS


@pytest.mark.parametrize("name", RUNNABLE, ids=" ".join)
def test_a_command_has_help_with_an_example_and_a_word_on_every_option(
    name: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, *name, "--help")
    assert (ended.status, ended.said) == (0, "")
    text = " ".join(ended.out.split())
    assert "Example: " in text or "Examples: " in text or "Example, " in text
    assert f"tendond {' '.join(name)}" in text.split("Example", 1)[1]
    for parameter in RUNNABLE[name].params:
        assert parameter.help, f"{name}: {parameter.name} says nothing of itself"


@pytest.mark.parametrize("name", COMMANDS, ids=" ".join)
def test_wrong_usage_is_said_in_a_few_lines(name: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    for wrong in (["--no-such-option"], ["too", "many", "words", "by", "far", "=", "="]):
        ended = tendond(capsys, *name, *wrong)
        assert (ended.status, ended.out) == (2, "")
        assert few_lines(ended.said), ended.said


@pytest.mark.parametrize(
    "name", [name for name, one in RUNNABLE.items() if any(p.name == "config" for p in one.params)], ids=" ".join
)
@pytest.mark.parametrize("kind", ["missing", "folder", "unreadable", "no text", "no toml"])
def test_a_configuration_that_cannot_be_read_is_named(
    name: tuple[str, ...], kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = {"folder": tmp_path, "unreadable": Path("/proc/self/mem")}.get(kind, tmp_path / "rig.toml")
    if kind == "no text":
        path.write_bytes(b"\xff\xfe\x00")
    elif kind == "no toml":
        path.write_text("[rod\n")
    ended = tendond(capsys, *name, *REQUIRED.get(" ".join(name), []), "--config", str(path))
    assert ended.status == 2
    assert str(path) in ended.out + ended.said
    assert few_lines(ended.out + ended.said)


@pytest.mark.parametrize("name", LOG_COMMANDS, ids=" ".join)
@pytest.mark.parametrize("kind", ["missing", "folder", "unreadable", "no log", "empty"])
def test_a_log_that_cannot_be_read_is_named(
    name: tuple[str, ...], kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = {"folder": tmp_path, "unreadable": Path("/proc/self/mem")}.get(kind, tmp_path / "run.mcap")
    if kind in ("no log", "empty"):
        path.write_text("this is no log" if kind == "no log" else "")
    ended = tendond(capsys, *name, str(path))
    assert ended.status == 2
    assert str(path) in ended.said
    assert few_lines(ended.said)


@pytest.mark.parametrize(
    "command",
    [
        ("log", "export", str(NORMAL), "--out", "/proc/no/such.csv"),
        ("log", "recover", str(NORMAL), "--out", "/proc/no/such.mcap"),
        ("report", str(NORMAL), "--out", "/proc/no/such.html"),
        ("plot", str(NORMAL), "--out", "/proc/no/such"),
        ("replay", str(NORMAL), "--law", "sliding_mode", "--out", "/proc/no/such.mcap"),
        ("demo", "--out", "/proc/no"),
        ("run", "--log", "/proc/no/such.mcap", "--lockstep", "--cycles", "1"),
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_a_place_that_cannot_be_written_is_named(command: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, *command)
    assert ended.status in (1, 2)
    assert "/proc/no" in ended.said
    assert few_lines(ended.said)


def test_json_is_json_and_nothing_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    normal = json.loads(tendond(capsys, "log", "info", str(NORMAL), "--json").out)
    assert normal["cycles"] > 100
    compared = json.loads(tendond(capsys, "compare", str(NORMAL), "--out", str(tmp_path), "--json").out)
    assert compared[NORMAL.stem]["settling_iterations"] > 0
    variant = tendond(
        capsys, "replay", str(NORMAL), "--law", "sliding_mode", "--out", str(tmp_path / "other.mcap"), "--json"
    )
    assert json.loads(variant.out)["tension_max"] > 0.0
    table = tendond(capsys, "replay", str(NORMAL), "--law", "sliding_mode", "--out", str(tmp_path / "third.mcap")).out
    assert "displacement" in table
    replayed = tendond(capsys, "replay", str(FAULTS), "--from", "0", "--to", "20", "--tolerance", "1e-3", "--json")
    found = json.loads(replayed.out)
    assert (found["equal"], replayed.status) == (True, 0)
    assert found["compared"] >= 20


def test_nothing_heavy_is_imported_for_help_or_completion() -> None:
    code = f"import sys, tendond.daemon.cli.app; print([name for name in {HEAVY} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_the_help_names_the_exit_statuses(capsys: pytest.CaptureFixture[str]) -> None:
    text = tendond(capsys, "--help").out
    assert "Exit status: 0 done; 1 refused" in text
    assert "130 interrupted" in text


@pytest.mark.parametrize("name", [(), *(name for name, one in COMMANDS.items() if getattr(one, "commands", {}))])
def test_a_commands_first_sentence_fits_its_line(name: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert "..." not in tendond(capsys, *name, "--help").out.split("Commands:")[1]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("tendond lo", {"log"}),
        ("tendond config s", {"show", "schema"}),
        ("tendond run --profile ", {"paper", "rig", "nasty"}),
        ("tendond law s", {"sliding_mode"}),
        ("tendond inject te", {"teleport"}),
    ],
)
def test_the_shell_completes(line: str, expected: set[str]) -> None:
    words = line.split(" ")
    environment = {
        **os.environ,
        "_TENDOND_COMPLETE": "complete_bash",
        "COMP_WORDS": line,
        "COMP_CWORD": str(len(words) - 1),
    }
    program = Path(sys.executable).with_name("tendond")
    found = subprocess.run([str(program)], env=environment, capture_output=True, text=True)
    assert set(found.stdout.split()) >= expected, found.stderr
    assert not found.stderr


def test_completion_can_be_installed_in_bash(capsys: pytest.CaptureFixture[str]) -> None:
    program = Path(sys.executable).with_name("tendond")
    environment = {**os.environ, "_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION": "1"}  # there may be no shell around it
    command = [str(program), "--show-completion", "bash"]
    found = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert "complete -o default -F _tendond_completion tendond" in found.stdout
    if bash := shutil.which("bash"):
        subprocess.run([bash, "-n"], input=found.stdout, text=True, check=True)


def test_a_reader_that_leaves_is_no_error() -> None:
    command = " ".join([*TENDOND, "config", "show", "|", "head", "-n", "1"])
    found = subprocess.run(["sh", "-c", command], capture_output=True, text=True)
    assert (found.stdout, found.stderr) == ("[rig]\n", "")
    with subprocess.Popen([*TENDOND, "config", "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


@pytest.mark.parametrize("seconds", [0.25, 0.4, 0.7, 1.1])
@pytest.mark.parametrize("command", ["run", "simulate", "arm"])
def test_ctrl_c_at_any_moment_of_a_start_is_quiet_and_130(command: str, seconds: float, tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('[bus]\nendpoint = "tcp/127.0.0.1:9"\n')
    process = subprocess.Popen(
        [*TENDOND, command, "--config", str(tmp_path / "rig.toml")],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    time.sleep(seconds)
    if process.poll() is None:
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60.0)
        assert "Traceback" not in said
        assert process.returncode in (130, 1 if "no controller" in said or "cannot listen" in said else 130), said
    process.communicate()


@pytest.mark.parametrize("command", ["run", "simulate", "arm"])
@pytest.mark.parametrize("text", [None, "{ this is not json5"], ids=["missing", "broken"])
def test_a_zenoh_configuration_that_cannot_be_used_is_a_line_and_exit_2(
    command: str, text: str | None, tmp_path: Path
) -> None:
    file = tmp_path / "broken.json5"
    if text is not None:
        file.write_text(text)
    found = subprocess.run(
        [*TENDOND, command, *(["--cycles", "1"] if command != "arm" else [])],
        cwd=tmp_path, env={**os.environ, "ZENOH_CONFIG": str(file)}, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert found.returncode == 2
    (line,) = [line for line in found.stderr.splitlines() if "ZENOH_CONFIG" in line]
    assert str(file) in line
    assert "Traceback" not in found.stderr


@pytest.mark.parametrize("command", [("simulate",), ("vicon",), ("paper",)], ids=lambda command: command[0])
def test_ctrl_c_ends_without_a_traceback(command: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text('[bus]\nendpoint = "tcp/127.0.0.1:9"\n[vicon]\nport = 51999\n')
    options = ["--out", str(tmp_path / "out")] if command == ("paper",) else ["--config", str(tmp_path / "rig.toml")]
    process = subprocess.Popen(
        [*TENDOND, *command, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60.0)
    assert "Traceback" not in said
    assert process.returncode in (0, 130)
