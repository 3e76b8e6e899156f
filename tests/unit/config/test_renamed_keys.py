"""Old names of configuration keys are read as the new ones, with one line that names the new key."""

import pytest

from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.renamed import REMOVED, RENAMED, RenamedKeyWarning
from tendond.schemas.config.rig import ConfigError, RigConfig, parse_config

OTHER_VALUES: dict[str, object] = {
    "loop.speculate": False,
    "pretension.tension_min": 1.5,
    "faults.frozen_distance": 0.03,
    "faults.slack_fraction": 0.3,
    "commissioning.tension_fraction": 0.05,
    "servo.reply_timeout": 0.008,
}
"""A value of each renamed key that is not its default."""


def toml(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else repr(value)


@pytest.mark.parametrize(("section", "old"), RENAMED)
def test_an_old_name_sets_the_new_key_and_one_line_says_so(section: str, old: str) -> None:
    name = RENAMED[section, old]
    value = OTHER_VALUES[f"{section}.{name}"]
    with pytest.warns(RenamedKeyWarning) as caught:
        config = parse_config(f"[{section}]\n{old} = {toml(value)}\n", "rig.toml")
    default = getattr(parse_config(f"[{section}]\n", "rig.toml"), section)
    assert getattr(getattr(config, section), name) == value != getattr(default, name)
    said = [str(warning.message) for warning in caught]
    assert said == [f"rig.toml: {section}.{old} was renamed to {section}.{name}: use that key"]


@pytest.mark.parametrize(("section", "old"), RENAMED)
def test_an_old_name_beside_the_new_one_is_refused(section: str, old: str) -> None:
    name = RENAMED[section, old]
    value = toml(OTHER_VALUES[f"{section}.{name}"])
    with pytest.raises(ConfigError, match=f"^rig.toml:2: {section}.{old}: was renamed to {section}.{name}, which is"):
        parse_config(f"[{section}]\n{old} = {value}\n{name} = {value}\n", "rig.toml")


def test_no_default_of_the_schema_has_an_old_name() -> None:
    tables = parse_config("[servo]\n", "rig.toml").model_dump()
    assert not [path for path in RENAMED if path[1] in tables[path[0]]]


@pytest.mark.parametrize(("old", "new"), [("far", "above_135"), ("near", "below_135")])
def test_an_old_name_of_a_branch_is_read_with_one_line_and_in_requests_and_logs_without(old: str, new: str) -> None:
    with pytest.warns(RenamedKeyWarning) as caught:
        config = parse_config(f'[reference]\nacross = 0.34\nbranch = "{old}"\n', "rig.toml")
    assert config.reference.branch == new
    said = [str(warning.message) for warning in caught]
    assert said == [f"rig.toml: reference.branch = '{old}' was renamed to '{new}': use that value"]
    assert ReferenceSection.model_validate({"across": 0.34, "branch": old}).branch == new


@pytest.mark.parametrize(("section", "old"), REMOVED)
def test_a_removed_key_changes_nothing_and_one_line_says_why(section: str, old: str) -> None:
    with pytest.warns(RenamedKeyWarning) as caught:
        config = parse_config(f"[{section}]\n{old} = 0.02\n", "rig.toml")
    assert config == RigConfig()
    said = [str(warning.message) for warning in caught]
    assert said == [f"rig.toml: {section}.{old} is no longer used ({REMOVED[section, old]}): remove it"]
