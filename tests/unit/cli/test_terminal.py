"""Commands at a terminal: completion, closed pipes, Ctrl-C, and locales without Unicode."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.golden.scripts import FOLDER
from tests.rig.tracker import free_port
from tests.unit.cli.commands import TENDOND

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("tendond lo", {"log"}),
        ("tendond config s", {"show", "schema"}),
        ("tendond run --profile ", {"paper", "rig", "nasty"}),
        ("tendond rig law s", {"sliding_mode"}),
        ("tendond rig inject te", {"teleport"}),
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
    assert (found.stdout.split("  #")[0].strip(), found.stderr) == ("version = 2", "")
    with subprocess.Popen([*TENDOND, "config", "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


UNSTARTED = "Fatal Python error"
"""Printed by an interpreter that is interrupted before it has started: nothing of the command has run."""


def interrupted(command: list[str], folder: Path, moment: float) -> "subprocess.CompletedProcess[str]":
    """A command that is sent Ctrl-C so many seconds after Python itself is there: it takes long on a busy machine."""
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", "import signal"], check=True)
    moment += 2.0 * (time.monotonic() - began)
    while True:
        process = subprocess.Popen(
            [*TENDOND, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder
        )
        time.sleep(moment)
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=60.0)
        if UNSTARTED not in said:
            return subprocess.CompletedProcess(command, process.returncode, out, said)
        moment *= 2.0


@pytest.mark.parametrize("moment", [0.3, 2.0])
@pytest.mark.parametrize(
    "command",
    [
        "run --log {}.mcap",
        "rig vicon",
        "simulate",
        "study paper --out out",
        "doctor --no-servos",
        "watch",
        "config check",
    ],
    ids=lambda command: " ".join(word for word in command.split() if word.isalpha()),
)
def test_ctrl_c_ends_every_command_quietly_with_130_at_any_moment(command: str, moment: float, tmp_path: Path) -> None:
    """Commands end while they import, compile, or wait; what has ended by itself before that has its own status."""
    port = free_port(socket.SOCK_STREAM)
    text = f'[bus]\nendpoint = "tcp/127.0.0.1:{port}"\n[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n'
    (tmp_path / "rig.toml").write_text(text)
    words = command.format("run").split()
    options = [] if "paper" in words else ["--config", "rig.toml"]
    found = interrupted([*words, *options], tmp_path, moment)
    assert "Traceback" not in found.stderr
    assert "ignored" not in found.stderr
    ends_by_itself = words[0] in ("doctor", "config")
    assert found.returncode == 130 or (ends_by_itself and found.returncode in (0, 1) and found.stdout), found


NO_UNICODE = [
    {"PYTHONIOENCODING": "ascii"},
    {"PYTHONIOENCODING": "latin-1"},
    {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
]


@pytest.mark.parametrize("environment", NO_UNICODE, ids=["ascii", "latin-1", "ascii-locale"])
def test_names_that_a_terminal_or_a_locale_cannot_show_are_replaced_and_the_status_is_that_of_the_work(
    environment: dict[str, str], tmp_path: Path
) -> None:
    log, config = tmp_path / "Prüfstand.mcap", tmp_path / "Prüfstand.toml"
    shutil.copy(NORMAL, log)
    config.write_text('[rig]\nname = "bench"\n')
    documents = [
        (["log", "report", str(log)], 0),
        (["log", "compare", str(log), str(log), "--out", str(tmp_path / "compared")], 0),
        (["log", "export", str(log)], 0),
    ] * ("LC_ALL" in environment)  # files do not depend on the terminal's encoding
    for words, status in (
        (["config", "check", str(config)], 0),
        (["config", "check", str(tmp_path / "Nähe.toml")], 2),
        (["log", "info", str(log)], 0),
        *documents,
    ):
        found = subprocess.run([*TENDOND, *words], env={**os.environ, **environment}, capture_output=True)
        assert found.returncode == status, (words, found)
        assert b"Traceback" not in found.stderr, (words, found)
    if documents:
        assert "Prüfstand" in (tmp_path / "Prüfstand.html").read_text(encoding="utf-8")
