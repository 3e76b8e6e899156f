"""Commands, options, configurations and links in the documents exist."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest
from typer.main import get_command

from tendond.cli.app import app
from tendond.cli.manual.bus import keys_page, log_page, messages_page
from tendond.cli.manual.commands import commands_page
from tendond.cli.manual.configuration import configuration_page
from tendond.cli.manual.links import ROOT_PAGES, source_page, with_links
from tendond.cli.manual.markdown import attributes, table
from tendond.cli.manual.pictures import watch_picture
from tendond.schemas import keys
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.errors.keywords import tables
from tendond.schemas.health import LoopHealth
from tendond.schemas.messages import Status
from tendond.schemas.requests import ControlAction
from tendond.schemas.topics import TOPICS
from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import subcommands

ROOT = Path(__file__).parents[3]
DOCUMENTS = sorted([ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("deploy/**/*.md")])
BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"^ {4}((?:[A-Z_]+=\S+ )?(?:\.venv/bin/)?tendond .*)$", re.MULTILINE)


def blocks(language: str) -> list[tuple[Path, str]]:
    """Every block of code of a language in the documents."""
    return [
        (path, found[3])
        for path in DOCUMENTS
        for found in BLOCK.finditer(path.read_text(encoding="utf-8"))
        if found[2] == language
    ]


def command_lines() -> list[tuple[str, list[str]]]:
    """Every line that calls tendond, with the words after it."""
    lines = [(path, line) for path, text in blocks("sh") for line in text.splitlines()]
    lines += [(path, found[1]) for path in DOCUMENTS for found in INDENTED.finditer(path.read_text(encoding="utf-8"))]
    found = []
    for path, line in lines:
        words = shlex.split(line.split("  #")[0].split(" | ")[0].split(" > ")[0], comments=True)
        words = [word for word in words if not re.fullmatch(r"[A-Z_]+=\S+", word)]
        if words and words[0].endswith("tendond"):
            found.append((f"{path.relative_to(ROOT)}: {line.strip()}", words[1:]))
    return found


LINES = command_lines()


def test_there_is_something_to_check() -> None:
    assert len(LINES) > 60
    assert len(blocks("toml")) >= 3


@pytest.mark.parametrize("words", [words for _, words in LINES], ids=[name for name, _ in LINES])
def test_every_command_in_the_documents_exists(words: list[str]) -> None:
    command = get_command(app)
    while words and words[0] in getattr(command, "commands", {}):
        command = subcommands(command)[words[0]]
        words = words[1:]
        assert not command.hidden, "an old spelling"
    command = getattr(command, "commands", {}).get(getattr(command, "default", ""), command)
    assert not getattr(command, "commands", {}) or command.invoke_without_command
    known = {
        name for one in command.params if not getattr(one, "hidden", False) for name in (*one.opts, *one.secondary_opts)
    } | {"--help", "-h"}
    for word in words:
        if word.startswith("-") and not re.fullmatch(r"-\d.*", word):
            assert word.split("=")[0] in known, word
    if not any(one.param_type_name == "argument" for one in command.params):
        positional = [word for before, word in zip(["", *words], words, strict=False) if not word.startswith("-")
                      and not before.startswith("-")]  # fmt: skip
        assert not positional


@pytest.mark.parametrize("text", [text for _, text in blocks("toml") if "[project]" not in text])
def test_every_configuration_in_the_documents_can_be_used(text: str) -> None:
    tomllib.loads(text)
    parse_config(text, "document")


@pytest.mark.parametrize("page", sorted({path for path, _ in blocks("python")}), ids=lambda page: page.name)
def test_every_program_in_the_documents_runs(page: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """One after the other, as they are read: each with what those above it on its page have made."""
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(tmp_path)
    for name in ("run.mcap", "first.mcap"):
        (tmp_path / name).write_bytes((FOLDER / "faults.mcap").read_bytes())
    values: dict[str, object] = {}
    exec("import numpy as np\nfrom tendond.offline.logs import load\nrun = load('run.mcap')\n", values)
    for path, text in blocks("python"):
        code = compile(text, str(path), "exec")
        if path == page and "frames()" not in text:  # needs a camera
            exec(code, values)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(path: Path) -> None:
    """Links within the site are checked by mkdocs, anchors too; a reader of the files follows them as well."""
    prose = BLOCK.sub("", path.read_text(encoding="utf-8"))
    generated = ("reference/", *ROOT_PAGES.values())
    for target in re.findall(r"\]\(([^)#\s]+)", prose):
        if "://" not in target and not any(name in target for name in generated):
            assert (path.parent / target).exists(), target


def test_the_pages_from_the_code_have_everything() -> None:
    commands, configuration = commands_page(), configuration_page()
    for name in ("tendond run", "tendond config check", "tendond servo calibrate", "--closed-loop"):
        assert name in commands
    for one in tables(RigConfig):
        for key in one.keys:
            assert f"| `{key.name}` |" in configuration or key.words == "a table"
    assert "`alpha1`" in configuration
    for topic in TOPICS:
        assert f"`<rig>/{topic.name}`" in keys_page()
        assert topic.message is None or f"## {topic.message.__name__}\n" in messages_page()
    assert "| `residual` | a number | N |" in log_page()


def test_the_list_of_topics_has_every_key_and_request() -> None:
    names = {topic.name for topic in TOPICS}
    assert names >= {keys.TIP_POSE, keys.TENDON_STATE, keys.TENDON_COMMAND, keys.STATUS, keys.SIMULATOR_TRUTH,
                     keys.SERVO_RESET, keys.SIMULATOR_INJECT, keys.ALIVE}  # fmt: skip
    assert {f"{keys.CONTROL}/{action.value}" for action in ControlAction} <= names


def test_attributes_come_from_the_docstring() -> None:
    said = attributes(LoopHealth)
    assert said["cycle_ms_p99"] == said["cycle_ms_median"]
    assert said["cycle_ms_p99"].startswith("time from wake-up to command [ms], over the last seconds;")
    assert attributes(Status)["tip"] == "measured position in use [m]; none before the first pose."


def test_cells_of_a_table_stay_in_their_line() -> None:
    assert table(("a",), [("x | y\nz",)]) == "| a |\n| --- |\n| x \\| y z |"


def test_the_picture_of_the_live_view_is_one_and_fetches_nothing() -> None:
    picture = watch_picture(FOLDER / "normal.mcap")
    assert "x-z" in picture
    assert "●" in picture
    assert re.findall(r"(?:href|src|url)[=(]", picture) == re.findall(r"url\((?=#)", picture)


def test_links_into_the_repository_become_pages() -> None:
    noted: list[str] = []
    text = (
        "[loop](../daemon/runtime/loop.py#x), [web](https://example.org), [lost](../no/such.py), [page](metrics.md)\n"
    )
    turned = with_links(text + "\n```\n[a](b)\n```\n", ROOT, "docs/howto/..", "control.md", noted.append)
    assert turned.startswith(
        "[loop](source/daemon/runtime/loop.py.md#x), [web](https://example.org), [lost](../no/such.py), "
    )
    assert "[page](metrics.md)" in turned
    assert turned.endswith("```\n[a](b)\n```\n")
    assert noted == ["daemon/runtime/loop.py"]
    page, folder = source_page(ROOT, "deploy/bus")
    assert folder == "deploy/bus"
    assert "[`controller.json5`](controller.json5)" in page
