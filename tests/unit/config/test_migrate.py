"""Configuration files of old versions are rewritten to the present one: same meaning, same comments."""

import os
import re
import warnings
from pathlib import Path

import pytest

from tendond.schemas.config.migration.migrate import MigrationError, migrate
from tendond.schemas.config.migration.version import CONFIG_VERSION
from tendond.schemas.config.renamed import IN_SECONDS, REMOVED, RENAMED, RenamedKeyWarning
from tendond.schemas.config.rig import ConfigError, RigConfig, parse_config
from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import tendond

OLD = FOLDER / "v1" / "rig.toml"
"""deploy/rig.toml of an early version: every key, none under its present name where that has changed. Never renewed."""


def read(text: str) -> RigConfig:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RenamedKeyWarning)
        return parse_config(text, "rig.toml")


def comments(text: str) -> list[str]:
    return re.findall(r"^# .*$", text, re.M)


def test_the_file_of_version_1_has_every_old_name_of_its_time() -> None:
    text = OLD.read_text()
    later = {"tension_part"}
    for _, old in [*RENAMED, *IN_SECONDS, *REMOVED]:
        assert old in later or re.search(rf"^#?{old} = ", text, re.M), old


def test_a_file_of_version_1_is_read_the_same_after_the_migration_and_without_a_warning() -> None:
    found = migrate(OLD.read_text(), "rig.toml")
    assert found.before == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert parse_config(found.new, "rig.toml") == read(found.old)
    missing = set(comments(found.old)) - set(comments(found.new))
    assert not missing, "comments survive"
    assert len(found.changes) == len(RENAMED) - 2 + len(IN_SECONDS) + len(REMOVED) + 1
    assert migrate(found.new, "rig.toml").changes == []
    assert migrate(found.new, "rig.toml").new == found.new


FORMS = {
    "a table": "[loop]\nrehearse = false  # mine\n",
    "spaces": "[ loop ]\n  rehearse   =   false\n",
    "later": "[commissioning]\ntension_part = 0.05\n",
    "dotted": "loop.rehearse = false\n",
    "inline": "loop = { rehearse = false, period = 0.02 }\n",
    "quoted": '[loop]\n"rehearse" = false\n',
    "a comment with its name": "[loop]\n# rehearse = true was slower\nrehearse = false\n",
    "cycles": "[loop]\nperiod = 0.004\n[faults]\npose_stale = 25  # a quarter of a lap\n",
    "a value": "[reference]\nacross = 0.34\nbranch = 'far' # behind\n",
    "removed": "[observer]\nquiet = 0.02  # once measured\n",
    "removed with others": "[observer]\nquiet = 0.02\ndelay = 0.01\n",
    "no end of line": "[loop]\nrehearse = false",
    "windows": "[loop]\r\nrehearse = false\r\n",
    "version 1": "version = 1  # of ours\n[loop]\nrehearse = false\n",
}


@pytest.mark.parametrize("form", FORMS)
def test_keys_are_found_however_they_are_spelled(form: str) -> None:
    text = FORMS[form]
    found = migrate(text, "rig.toml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert parse_config(found.new, "rig.toml") == read(text)
    for comment in re.findall(r"# \w.*", text):
        assert comment.strip() in found.new
    assert f"version = {CONFIG_VERSION}" in found.new


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[observer", "is not valid TOML"),
        ("[loop]\nrehearse = true\nspeculate = true\n", "which is given too"),
        ('include = ["a.toml"]\n[faults]\npose_stale = 5\n', "write loop.period into this file"),
        ("observer = { quiet = 0.1 }\n", "change the keys that 'tendond config check rig.toml' names"),
        (f"version = {CONFIG_VERSION + 1}\n", "upgrade tendond"),
    ],
)
def test_a_file_that_cannot_be_rewritten_is_refused_in_one_line(text: str, said: str) -> None:
    with pytest.raises(MigrationError, match=r"^rig\.toml: ") as refused:
        migrate(text, "rig.toml")
    line = str(refused.value)
    assert said in line
    assert "\n" not in line


def test_the_version_stands_before_the_first_table_and_its_comment_behind_that_of_the_file() -> None:
    head = migrate("# My rig.\n\n# Its name.\n[rig]\nname = 'a'\n", "rig.toml").new
    assert head == f"# My rig.\n\nversion = {CONFIG_VERSION}\n\n# Its name.\n[rig]\nname = 'a'\n"
    assert migrate("# Nothing.\n", "rig.toml").new == f"# Nothing.\nversion = {CONFIG_VERSION}\n"
    assert migrate("", "rig.toml").new == f"version = {CONFIG_VERSION}\n"


@pytest.mark.parametrize("version", [0, -1, '"2"', "true", 1.5, CONFIG_VERSION + 1])
def test_a_version_that_is_not_known_is_refused_alone_with_its_line(version: object) -> None:
    text = f"# mine\nversion = {version}\n[unknown]\nkey = 1\n"
    with pytest.raises(ConfigError, match=r"^rig\.toml:2: version = ") as refused:
        parse_config(text, "rig.toml")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("version", [None, 1, CONFIG_VERSION])
def test_a_file_with_and_without_a_version_is_read_alike(version: int | None) -> None:
    head = "" if version is None else f"version = {version}\n"
    assert parse_config(f"{head}[loop]\nperiod = 0.02\n", "rig.toml") == parse_config("[loop]\nperiod = 0.02\n", "r")


def test_an_included_file_of_a_newer_version_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "part.toml").write_text(f"version = {CONFIG_VERSION + 1}\n[loop]\nperiod = 0.02\n")
    rig = tmp_path / "rig.toml"
    rig.write_text(f'version = {CONFIG_VERSION}\ninclude = ["part.toml"]\n')
    ended = tendond(capsys, "config", "check", "--no-model", str(rig))
    assert ended.status == 2
    assert f"{tmp_path / 'part.toml'}: version = {CONFIG_VERSION + 1}" in ended.said
    (tmp_path / "part.toml").write_text("version = 1\n[loop]\nperiod = 0.02\n")
    assert tendond(capsys, "config", "check", "--no-model", str(rig)).status == 0


def test_without_write_the_difference_is_shown_and_the_file_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text("[loop]\nrehearse = true")
    ended = tendond(capsys, "config", "migrate", str(rig))
    assert (ended.status, rig.read_text()) == (0, "[loop]\nrehearse = true")
    assert "-rehearse = true\n" in ended.out
    assert "+speculate = true\n" in ended.out
    assert "--write" in ended.said


def test_with_write_the_old_file_is_kept_and_mode_and_link_stay(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    real, rig = tmp_path / "real.toml", tmp_path / "rig.toml"
    real.write_text("[loop]\nrehearse = true\n")
    real.chmod(0o640)
    rig.symlink_to(real)
    ended = tendond(capsys, "config", "migrate", str(rig), "--write")
    assert ended.status == 0, ended.said
    assert "speculate = true" in real.read_text()
    assert rig.is_symlink()
    assert os.stat(real).st_mode & 0o777 == 0o640
    assert (tmp_path / "real.toml.v1").read_text() == "[loop]\nrehearse = true\n"
    assert "nothing to change" in tendond(capsys, "config", "migrate", str(rig), "--write").out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["real.toml", "real.toml.v1", "rig.toml"]


def test_a_file_that_cannot_be_read_or_written_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, "config", "migrate", str(tmp_path / "none.toml"))
    assert (ended.status, ended.said.count("\n")) == (2, 1)
    assert "none.toml: cannot be read" in ended.said


def test_what_config_show_writes_has_the_version(capsys: pytest.CaptureFixture[str]) -> None:
    text = tendond(capsys, "config", "show", "--profile", "rig").out
    assert text.startswith(f"version = {CONFIG_VERSION}\n")
    assert migrate(text, "rig.toml").changes == []
