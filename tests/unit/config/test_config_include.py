"""`include`: a file's own keys over those of the files that it names, and messages that name the right one."""

from pathlib import Path

import pytest

from tendond.cli.common import load_config
from tendond.schemas.config.rig import ConfigError


def written(folder: Path, **files: str) -> Path:
    for name, text in files.items():
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return folder / "rig.toml"


def test_the_files_own_keys_go_over_the_included_ones_and_later_ones_over_earlier(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        rig='include = ["one.toml", "two.toml"]\n[rod]\ndensity = 5.0\n[rig]\nname = "arm"\n',
        one="[rod]\ndensity = 1.0\nyoungs_modulus = 1e11\nlength = 0.4\n[observer]\ndelay = 0.02\n",
        two="[rod]\nyoungs_modulus = 2e11\n",
    )
    config = load_config(path)
    assert (config.rod.density, config.rod.youngs_modulus, config.rod.length) == (5.0, 2e11, 0.4)
    assert (config.observer.delay, config.rig.name) == (0.02, "arm")


def test_a_list_is_one_value(tmp_path: Path) -> None:
    path = written(
        tmp_path, rig='include = ["one.toml"]\n[rod]\ndrag = [1.0, 2.0, 3.0]\n', one="[rod]\ndrag = [9.0, 9.0, 9.0]\n"
    )
    assert load_config(path).rod.drag == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("rig", "one", "named", "match"),
    [
        ("", "[rod]\nlenght = 0.4\n", "one.toml", "lenght"),
        ("", "[rod]\nlength = -1.0\n", "one.toml", r"rod\.length"),
        ("", "[observer]\ndelay = 9\n[rod]\ndrag = [1.0, -2.0, 3.0]\n", "one.toml", r"rod\.drag"),
        ("[rod]\nlength = -1.0\n", "[rod]\nlength = 0.4\n", "rig.toml", r"rod\.length"),
        ("[rod]\nlenght = 1.0\n", "[rod]\ndensity = 1.0\n", "rig.toml", "lenght"),
        ("", "[rod\n", "one.toml", "is not valid TOML"),
        ("", 'include = ["two.toml"]\n', "one.toml", "must not include others"),
    ],
)
def test_an_error_names_the_file_that_it_is_in(tmp_path: Path, rig: str, one: str, named: str, match: str) -> None:
    path = written(tmp_path, rig=f'include = ["one.toml"]\n{rig}', one=one)
    with pytest.raises(ConfigError, match=match) as raised:
        load_config(path)
    assert all(line.startswith(str(tmp_path / named)) for line in str(raised.value).splitlines())


def test_each_wrong_key_is_said_with_its_own_file(tmp_path: Path) -> None:
    path = written(tmp_path, rig='include = ["one.toml"]\n[limits]\nslack = 9\n', one="[rod]\nlength = 99\n[limits]\n")
    with pytest.raises(ConfigError) as raised:
        load_config(path)
    lines = sorted(str(raised.value).splitlines())
    assert len(lines) == 2
    assert lines[0].startswith(f"{tmp_path / 'one.toml'}: rod.length")
    assert lines[1].startswith(str(path))


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ('include = ["none.toml"]\n', r"none\.toml: cannot be read: No such file"),
        ('include = "one.toml"\n', "include: must be a list of file names"),
        ("include = [1]\n", "include: must be a list of file names"),
    ],
)
def test_what_cannot_be_included_is_one_line(tmp_path: Path, text: str, match: str) -> None:
    with pytest.raises(ConfigError, match=match) as raised:
        load_config(written(tmp_path, rig=text, one=""))
    assert len(str(raised.value).splitlines()) == 1
