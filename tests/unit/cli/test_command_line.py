"""Every command: help with an example, bad usage in a few lines, no traceback for a mistake, no colours where piped."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from tendond.bus.file import read_bus_file
from tendond.cli.app import app
from tendond.cli.program import EVERYDAY, MOVED
from tendond.offline.demo.scenarios import SCENARIOS
from tests.golden.scripts import FOLDER
from tests.rig.tracker import free_port
from tests.unit.cli.commands import tendond

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"
TENDOND = [sys.executable, "-m", "tendond.cli"]
HEAVY = ("matplotlib", "mcap", "numba", "numpy", "plotly", "pydantic", "rich", "scipy", "zenoh")


def walk(command: Any, name: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command and group, by its words."""
    if name:
        yield name, command
    for word, inner in getattr(command, "commands", {}).items():
        yield from walk(inner, (*name, word))


COMMANDS = {name: one for name, one in walk(get_command(app)) if not one.hidden}
RUNNABLE = {
    name: one for name, one in COMMANDS.items() if not getattr(one, "commands", {}) or one.invoke_without_command
}
REQUIRED = {
    "rig law": ["backstepping"],
    "rig reference": ["across=0.3"],
    "rig inject": ["noise"],
    "servo setup": ["1"],
    "servo reboot": ["1"],
    "simulate": ["--wired"],
    "rig simulate": ["--wired"],
}
LOG_COMMANDS = [("log", "info"), ("log", "recover"), ("log", "export"), ("replay",), ("log", "compare"),
                ("plot",), ("log", "report"), ("log", "view"), ("log", "what-if", "--closed-loop")]  # fmt: skip


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
    short = name[-1] if name[:-1] == (EVERYDAY.get(name[-1]),) else " ".join(name)
    assert f"tendond {short}" in text.split("Example", 1)[1]
    for parameter in RUNNABLE[name].params:
        assert parameter.help, f"{name}: {parameter.name} has no help"


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
        ("log", "report", str(NORMAL), "--out", "/proc/no/such.html"),
        ("plot", str(NORMAL), "--out", "/proc/no/such"),
        ("log", "what-if", str(NORMAL), "--law", "sliding_mode", "--out", "/proc/no/such.mcap"),
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
    compared = json.loads(tendond(capsys, "log", "compare", str(NORMAL), "--out", str(tmp_path), "--json").out)
    assert compared[NORMAL.stem]["settling_iterations"] > 0
    variant = tendond(
        capsys, "log", "what-if", str(NORMAL), "--law", "sliding_mode", "--out", str(tmp_path / "other.mcap"), "--json"
    )
    assert json.loads(variant.out)["tension_max"] > 0.0
    table = tendond(
        capsys, "log", "what-if", str(NORMAL), "--law", "sliding_mode", "--out", str(tmp_path / "third.mcap")
    ).out
    assert "displacement" in table
    replayed = tendond(capsys, "replay", str(FAULTS), "--from", "0", "--to", "20", "--tolerance", "1e-3", "--json")
    found = json.loads(replayed.out)
    assert (found["equal"], replayed.status) == (True, 0)
    assert found["compared"] >= 20


@pytest.mark.parametrize("old", MOVED)
def test_an_old_spelling_is_hidden_and_runs_with_a_line_that_names_the_new_one(
    old: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command, ran = get_command(app).commands[old], []  # type: ignore[attr-defined]
    assert command.hidden
    assert f"\n  {old} " not in tendond(capsys, "--help").out
    for scenario in ("wired", "spatial"):
        monkeypatch.setitem(SCENARIOS, scenario, lambda out: ran.append(out))
    monkeypatch.setattr("tendond.cli.study.paper.run_paper", lambda *given: ran.append(given))
    monkeypatch.setattr("tendond.cli.study.robustness.run_robustness", lambda *given, **more: ran.append(given))
    arguments = {"law": ["backstepping"], "reference": ["across=0.3"], "inject": ["noise"]}.get(old, [])
    if any(one.name == "config" for one in command.params) and old != "robustness":
        arguments = [*arguments, "--config", "/nowhere/rig.toml"]
    elif old in ("compare", "report"):
        arguments = ["/nowhere/run.mcap"]
    ended = tendond(capsys, old, *arguments)
    first, *rest = ended.said.splitlines()
    assert first == f"tendond: 'tendond {old}' is now 'tendond {MOVED[old].now}'"
    if ran:
        assert (ended.status, rest) == (0, [])
        assert "demo" not in old or ran == [Path(f"out/demo-{MOVED[old].values['scenario']}")]
    else:
        assert ended.status == 2
        assert "/nowhere/" in rest[0]


def test_a_replay_with_a_change_runs_as_what_if(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new, old = tmp_path / "new.mcap", tmp_path / "old.mcap"
    first = tendond(capsys, "log", "what-if", str(FAULTS), "--set", "limits.tension_max=30", "--out", str(new))
    second = tendond(capsys, "replay", str(FAULTS), "--set", "limits.tension_max=30", "--out", str(old))
    assert (first.status, second.status) == (0, 0)
    assert second.said == (
        "tendond: 'tendond replay --law, --set, --closed-loop' is now 'tendond log what-if'\n" + first.said
    )
    assert first.out.splitlines()[:-1] == second.out.splitlines()[:-1]
    for command in ("replay", "log what-if"):
        assert (
            tendond(capsys, *command.split(), str(NORMAL), *["--out", str(new)][: 2 * (command == "replay")]).status
            == 2
        )


def test_the_top_level_help_lists_groups_first_and_is_short(capsys: pytest.CaptureFixture[str]) -> None:
    text = tendond(capsys, "--help").out
    assert text.index("Command groups:") < text.index("Everyday commands:")
    assert len(text.splitlines()) <= 45
    for name in ("rig", "log", "study", "run", "replay"):
        assert f"\n  {name} " in text


def test_nothing_heavy_is_imported_for_help_or_completion() -> None:
    code = f"import sys, tendond.cli.app; print([name for name in {HEAVY} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_the_help_names_the_exit_statuses(capsys: pytest.CaptureFixture[str]) -> None:
    text = tendond(capsys, "--help").out
    assert "Exit status: 0 success; 1 refused" in text
    assert "130 interrupted" in text


@pytest.mark.parametrize("name", [(), *(name for name, one in COMMANDS.items() if getattr(one, "commands", {}))])
def test_a_commands_first_sentence_fits_its_line(name: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert "..." not in tendond(capsys, *name, "--help").out.split("ommand", 1)[1]


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
    assert (found.stdout.split("  #")[0].strip(), found.stderr) == ("[rig]", "")
    with subprocess.Popen([*TENDOND, "config", "schema"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


def interrupted(command: list[str], folder: Path, moment: float) -> "subprocess.CompletedProcess[str]":
    """A command that is sent Ctrl-C so many seconds after Python itself is there: it takes long on a busy machine."""
    began = time.monotonic()
    subprocess.run([sys.executable, "-c", "import signal"], check=True)
    moment += 2.0 * (time.monotonic() - began)
    process = subprocess.Popen(
        [*TENDOND, *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder
    )
    time.sleep(moment)
    process.send_signal(signal.SIGINT)
    out, said = process.communicate(timeout=60.0)
    return subprocess.CompletedProcess(command, process.returncode, out, said)


@pytest.mark.parametrize("moment", [0.3, 1.0, 2.5])
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
    """Also while it imports, compiles, or waits; what has ended by itself before that has its own status."""
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
    ] * ("LC_ALL" in environment)  # what is written there besides is the same everywhere
    for words, status in (
        (["config", "check", str(config)], 0),
        (["config", "check", str(tmp_path / "Nähe.toml")], 2),
        (["log", "info", str(log)], 0),
        (["log", "export", str(log)], 0),
        *documents,
    ):
        found = subprocess.run([*TENDOND, *words], env={**os.environ, **environment}, capture_output=True)
        assert found.returncode == status, (words, found)
        assert b"Traceback" not in found.stderr, (words, found)
    if documents:
        assert "Prüfstand" in (tmp_path / "Prüfstand.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("broken", ["missing", "no json5", "names a missing certificate", "names an empty one"])
@pytest.mark.parametrize("command", ["run --cycles 1", "rig vicon", "simulate", "status", "arm", "watch --once"])
def test_a_bus_file_that_cannot_be_used_is_a_wrong_configuration_for_every_process(
    command: str, broken: str, tmp_path: Path
) -> None:
    file = tmp_path / "bus.json5"
    if broken == "no json5":
        file.write_text("{ this is not json5")
    elif broken == "names a missing certificate":
        file.write_text('{transport: {link: {tls: {root_ca_certificate: "/nowhere/ca.pem"}}}}')
    elif broken == "names an empty one":
        (tmp_path / "ca.pem").touch()
        file.write_text(f'{{transport: {{link: {{tls: {{root_ca_certificate: "{tmp_path}/ca.pem"}}}}}}}}')
    (tmp_path / "rig.toml").write_text(f"[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n")
    found = subprocess.run(
        [*TENDOND, *command.split(), "--config", "rig.toml"],
        env={**os.environ, "ZENOH_CONFIG": str(file)}, cwd=tmp_path, capture_output=True, text=True, timeout=60.0,
    )  # fmt: skip
    assert found.returncode == 2, found
    *_, last = found.stderr.splitlines()
    assert last.startswith(f"tendond: ZENOH_CONFIG = {file}: ")
    assert "Traceback" not in found.stderr


def self_signed(folder: Path, name: str) -> None:
    """A certificate and its key, in PEM."""
    curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")
    files = ("-keyout", str(folder / f"{name}.key"), "-out", str(folder / f"{name}.pem"))
    command = ["openssl", "req", "-x509", *curve, "-days", "9", "-subj", f"/CN={name}", *files]
    subprocess.run(command, check=True, capture_output=True)


@pytest.mark.parametrize(
    ("authority", "certificate", "private", "said"),
    [
        ("damaged.pem", "own.pem", "own.key", "root_ca_certificate = {}/damaged.pem: holds no certificate"),
        ("own.key", "own.pem", "own.key", "root_ca_certificate = {}/own.key: holds no certificate"),
        ("own.pem", "damaged.pem", "own.key", "connect_certificate = {}/damaged.pem: holds no certificate"),
        ("own.pem", "own.pem", "other.key", "connect_private_key = {}/other.key: is not the key of {}/own.pem"),
        ("own.pem", "own.pem", "own.pem", "connect_private_key = {}/own.pem: holds no private key"),
        ("own.pem", "own.pem", "own.key", None),
    ],
)
def test_a_bus_file_with_the_wrong_certificate_or_key_is_a_wrong_configuration(
    authority: str, certificate: str, private: str, said: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    self_signed(tmp_path, "own")
    self_signed(tmp_path, "other")
    first, *_, last = (tmp_path / "own.pem").read_text().splitlines()
    (tmp_path / "damaged.pem").write_text(f"{first}\nbm8gY2VydGlmaWNhdGU=\n{last}\n")
    names = {"root_ca_certificate": authority, "connect_certificate": certificate, "connect_private_key": private}
    tls = {name: str(tmp_path / file) for name, file in names.items()}
    (tmp_path / "bus.json5").write_text(json.dumps({"transport": {"link": {"tls": tls}}}))
    monkeypatch.setenv("ZENOH_CONFIG", str(tmp_path / "bus.json5"))
    if said is None:
        read_bus_file()
        return
    found = subprocess.run([*TENDOND, "status"], cwd=tmp_path, capture_output=True, text=True, timeout=60.0)
    assert found.returncode == 2, found
    (line,) = found.stderr.splitlines()
    assert said.replace("{}", str(tmp_path)) in line


def test_a_machine_with_no_folder_for_kernels_at_all_is_told_in_a_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def imports_a_kernel(*_: object, **__: object) -> None:
        raise RuntimeError("cannot cache function 'march': no locator available for file '/usr/lib/march.py'")

    monkeypatch.setattr("tendond.cli.config.check.run_check", imports_a_kernel)
    found = tendond(capsys, "config", "check")
    assert found.status == 1
    assert found.said == (
        "tendond: no folder for compiled kernels can be written: set NUMBA_CACHE_DIR to one that can\n"
    )
