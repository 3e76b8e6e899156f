"""One style of error: every command says what is wrong in a line that begins with its name and ends with the remedy."""

import re
import signal
import socket
import subprocess
import sys
from inspect import unwrap
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest

from tendond.cli.errors import in_our_words
from tests.rig.tracker import free_port
from tests.unit.cli.commands import COMMANDS, RUNNABLE, tendond
from tests.unit.cli.test_unusable_files import REQUIRED

USAGE_LINE = re.compile(r"tendond: \S.*(; see|\? See) 'tendond( [a-z0-9-]+)* --help'\n")
GROUPS = [(), *(name for name, one in COMMANDS.items() if getattr(one, "commands", {}))]

ON_THE_BUS = [
    "arm",
    "arm --wait",
    "stop",
    "reset",
    "status",
    "watch --once",
    "rig law backstepping",
    "rig reference across=0.3",
    "set limits.tension_max=40",
    "rig get",
    "rig inject noise",
    "rig teach record",
    "servo reset",
    "log view",
]
"""Commands that need a running controller."""


def numeric(command: Any) -> str | None:
    """Return an option of a command that takes a number."""
    hints = get_type_hints(unwrap(command.callback))
    for one in command.params:
        hint = hints.get(one.name)
        if one.param_type_name == "option" and {int, float} & {hint, *get_args(hint)}:
            return str(one.opts[0])
    return None


@pytest.mark.parametrize("name", COMMANDS, ids=" ".join)
def test_an_unknown_option_is_a_line_that_names_the_commands_help(
    name: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, *name, "--no-such-option")
    assert (ended.status, ended.out) == (2, "")
    assert USAGE_LINE.fullmatch(ended.said), ended.said
    assert "--no-such-option" in ended.said
    assert f"see 'tendond {' '.join(name)}" in ended.said


@pytest.mark.parametrize("name", [name for name, one in RUNNABLE.items() if numeric(one)], ids=" ".join)
def test_a_word_where_a_number_belongs_is_a_line_that_names_the_option(
    name: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    option = numeric(RUNNABLE[name])
    assert option is not None
    ended = tendond(capsys, *name, *REQUIRED.get(" ".join(name), []), option, "many")
    assert (ended.status, ended.out) == (2, "")
    assert USAGE_LINE.fullmatch(ended.said), ended.said
    assert ended.said.startswith(f"tendond: {option}: must be "), ended.said


@pytest.mark.parametrize("name", GROUPS, ids=lambda name: " ".join(name) or "tendond")
def test_an_unknown_command_is_a_line_and_a_near_one_is_named(
    name: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    if name[-1:] == ("identify",):  # an unknown word is a log
        return
    ended = tendond(capsys, *name, "no-such-command")
    assert (ended.status, ended.out) == (2, "")
    assert ended.said == f"tendond: no such command 'no-such-command'; see '{' '.join(('tendond', *name))} --help'\n"


def test_a_command_that_is_nearly_one_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, "log", "inof", "run.mcap")
    assert ended.said == "tendond: no such command 'inof': did you mean 'info'? See 'tendond log --help'\n"


@pytest.mark.parametrize("command", ON_THE_BUS)
def test_a_command_without_a_controller_is_a_line_that_says_how_to_start_one(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    (tmp_path / "rig.toml").write_text(f'[bus]\nendpoint = "{endpoint}"\n')
    ended = tendond(capsys, *command.split(), "--config", str(tmp_path / "rig.toml"))
    assert (ended.status, ended.out) == (1, "")
    said = ended.said.splitlines()
    assert all(line.startswith("tendond: ") for line in said), said
    assert re.fullmatch(rf"tendond: no .*{re.escape(endpoint)}: .*'tendond \w+'.*", said[-1]), said


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (["--version"], 0),
        (["log"], 2),
        (["config", "check", "/nowhere.toml"], 2),
        (["config", "show", "--preset", "nobody"], 2),
        (["log", "info", "/nowhere.mcap"], 2),
        (["config", "has", "vicon", "{}/empty.toml"], 1),
        (["run", "--lockstep", "--cycles", "1", "--log", "/proc/no/run.mcap"], 1),
    ],
    ids=lambda given: given if isinstance(given, int) else " ".join(given[:2]),
)
def test_the_exit_status_is_that_of_the_help(
    words: list[str], status: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty.toml").write_text("")
    assert tendond(capsys, *(word.format(tmp_path) for word in words)).status == status


def test_python_m_tendond_is_the_same_program_from_anywhere(tmp_path: Path) -> None:
    for module in ("tendond", "tendond.cli"):
        found = subprocess.run(
            [sys.executable, "-m", module, "stop", "--help"], capture_output=True, text=True, cwd=tmp_path
        )
        assert (found.returncode, found.stderr) == (0, "")
        assert found.stdout.startswith("Usage: tendond stop [OPTIONS]")
        wrong = subprocess.run([sys.executable, "-m", module, "stopp"], capture_output=True, text=True, cwd=tmp_path)
        assert wrong.stderr == "tendond: no such command 'stopp': did you mean 'stop'? See 'tendond --help'\n"


def test_the_words_of_the_library_become_ours() -> None:
    assert in_our_words("Invalid value for '--seed': Input should be a valid integer.") == (
        "--seed: must be a valid integer"
    )
    assert in_our_words("Invalid value: give the file once") == "give the file once"
    assert in_our_words("Missing argument 'LOG...'.") == "missing argument 'LOG...'"
    assert in_our_words("DATASET is missing") == "DATASET is missing"


def test_a_signal_is_no_error_line(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("tendond.cli.config.check.run_show", interrupted)
    ended = tendond(capsys, "config", "show")
    assert (ended.status, ended.said) == (130, "")


def test_standard_output_that_is_full_is_a_line() -> None:
    for words in (["config", "schema"], ["--help"], ["config", "show"]):
        with open("/dev/full", "w") as full:
            found = subprocess.run(
                [sys.executable, "-m", "tendond", *words], stdout=full, stderr=subprocess.PIPE, text=True
            )
        assert found.stderr == "tendond: the output cannot be written: No space left on device\n"
        assert found.returncode == 1
        with open("/dev/full", "w") as full:
            mute = subprocess.run([sys.executable, "-m", "tendond", "--no"], stderr=full, stdout=subprocess.PIPE)
        assert (mute.returncode, mute.stdout) == (2, b"")
