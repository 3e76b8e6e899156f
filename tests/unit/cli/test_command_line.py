"""Every command: help with an example, bad usage in a few lines, JSON, old spellings."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from typer.main import get_command

from tendond.cli.app import app
from tendond.cli.program import EVERYDAY, MOVED
from tendond.offline.demo.scenarios import SCENARIOS
from tendond.schemas.config.presets import PROFILES
from tendond.schemas.config.rig import parse_config
from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import COMMANDS, RUNNABLE, few_lines, subcommands, tendond

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


HEAVY = ("matplotlib", "mcap", "numba", "numpy", "plotly", "pydantic", "rich", "scipy", "zenoh")


def test_there_are_commands_to_walk() -> None:
    assert len(COMMANDS) > 30
    assert ("config", "check") in COMMANDS
    assert ("log", "info") in COMMANDS


@pytest.mark.parametrize("name", EVERYDAY)
def test_an_everyday_command_is_that_of_its_group(name: str) -> None:
    groups = subcommands(get_command(app))
    assert groups[name] is subcommands(groups[EVERYDAY[name]])[name]


@pytest.mark.parametrize("name", RUNNABLE, ids=" ".join)
def test_a_command_has_help_with_an_example_and_a_word_on_every_option(
    name: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, *name, "--help")
    assert (ended.status, ended.said) == (0, "")
    text = " ".join(ended.out.split())
    assert "Example: " in text or "Examples: " in text or "Example, " in text
    short = " ".join(name).removesuffix(" fit")  # the default
    assert f"tendond {short}" in text.split("Example", 1)[1]
    for parameter in RUNNABLE[name].params:
        assert parameter.help, f"{name}: {parameter.name} has no help"


@pytest.mark.parametrize("name", COMMANDS, ids=" ".join)
def test_wrong_usage_is_said_in_a_few_lines(name: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    for wrong in (["--no-such-option"], ["too", "many", "words", "by", "far", "=", "="]):
        ended = tendond(capsys, *name, *wrong)
        assert (ended.status, ended.out) == (2, "")
        assert few_lines(ended.said), ended.said


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
    command, ran = subcommands(get_command(app))[old], []
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


def test_only_the_demo_in_the_plane_runs_without_a_clock(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    ran: list[tuple[object, ...]] = []
    monkeypatch.setattr("tendond.offline.demo.scenarios.run_plane", lambda *given, **more: ran.append((*given, more)))
    assert tendond(capsys, "demo", "--lockstep", "--out", str(tmp_path)).status == 0
    assert ran == [(tmp_path, "paper", {"lockstep": True, "plant": None})]
    refused = tendond(capsys, "demo", "--scenario", "wired", "--lockstep")
    assert (refused.status, len(ran)) == (2, 1)
    assert "runs in real time" in refused.said


@pytest.mark.parametrize("profile", ["paper", "nasty"])
def test_a_demo_on_another_plant_has_it_in_its_configuration(
    profile: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """One profile begins the table [simulator] itself, the other one not."""
    texts: list[str] = []
    monkeypatch.setattr("tendond.offline.demo.scenarios.run_chain", lambda _, text, *given, **more: texts.append(text))
    assert tendond(capsys, "demo", "--plant", "general", "--profile", profile, "--out", str(tmp_path)).status == 0
    found, own = (parse_config(one, "test").simulator for one in (texts[0], PROFILES[profile]))
    assert found == own.model_copy(update={"solver": "general"})


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--plant", "mujoko"), "did you mean 'mujoco'"),
        (("--plant", "mujoco", "--scenario", "wired"), "has a plant of its own"),
        (("--plant", "shooting", "--profile", "nasty"), "--plant shooting: profile 'nasty': .*no friction of tendons"),
    ],
)
def test_a_plant_that_a_demo_cannot_have_is_refused_before_it_begins(
    arguments: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    refused = tendond(capsys, "demo", *arguments, "--out", str(tmp_path / "out"))
    assert refused.status == 2
    assert re.search(words, refused.said)
    assert not (tmp_path / "out").exists()


def test_the_top_level_help_lists_groups_first_and_is_short(capsys: pytest.CaptureFixture[str]) -> None:
    text = tendond(capsys, "--help").out
    assert text.index("Command groups:") < text.index("Everyday commands:")
    assert len(text.splitlines()) <= 48
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
