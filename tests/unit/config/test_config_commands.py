"""`tendond config`: everything that is wrong at once, the configuration in effect, the schema for editors."""

import json
from pathlib import Path

import pytest

from tendond.cli.manual.config_text import config_schema, config_toml
from tendond.daemon.control.laws import LAWS
from tendond.schemas.config.presets import PROFILES, WIRED, WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.errors.keywords import tables
from tendond.schemas.errors.toml_lines import key_lines, line_of
from tests.unit.cli.commands import tendond

WIRED_RIG = f"{WIRED}\n[vicon]\n{WIRED_VICON}\n[servo]\n{WIRED_SERVO}"
LAWS_OF_ITS_OWN = "[control]\nlaw = 'sliding_mode'\n[control.laws.sliding_mode]\nk = 9.5\n[control.laws.backstepping]\n"
CONFIGURATIONS = {**PROFILES, "wired": WIRED_RIG, "laws": LAWS_OF_ITS_OWN, "empty sections": "[servo]\n" + WIRED}


def written(folder: Path, text: str) -> str:
    """A rig.toml."""
    path = folder / "rig.toml"
    path.write_text(text)
    return str(path)


def test_check_says_everything_at_once_with_line_value_and_range(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = """\
rod = 3

[limits]
tension_max = "strong"   # a comment with [brackets]

[loop]
periode = 0.01

[control.laws.backstepping]
alpha1 = -1.0
alpha3 = 2.0

[simulator.rod]
gravity = [0.0,
           0.0]
[[simulator.impacts]]
time = 1.0
force = [0.0, 0.0, 1.0]
[[simulator.impacts]]
time = -2.0
force = [0.0, 0.0, 1.0]
"""
    file = written(tmp_path, text)
    ended = tendond(capsys, "config", "check", file)
    assert (ended.status, ended.out) == (2, "")
    assert sorted(ended.said.splitlines()) == sorted(
        f"tendond: {line}"
        for line in (
            f"{file}:1: rod = 3: must be a table, [rod]",
            f'{file}:4: limits.tension_max = "strong": must be a number > 0 and <= 500 [N]',
            f"{file}:7: loop.periode: unknown key; did you mean 'period'?",
            f"{file}:10: control.laws.backstepping.alpha1 = -1.0: must be a number > 0 and <= 100000",
            f"{file}:11: control.laws.backstepping.alpha3: unknown key; did you mean 'alpha2'?",
            f"{file}:14: simulator.rod.gravity = [0.0, 0.0]: must be 3 numbers [m/s^2]",
            f"{file}:20: simulator.impacts[1].time = -2.0: must be a number >= 0 [s]",
            "note: cross-key checks run after these are fixed",
        )
    )


def test_check_finds_what_the_controller_would_refuse_at_its_start(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, "[control]\nlaw = 'pid'\n[reference]\nacross = 0.9\n")
    ended = tendond(capsys, "config", "check", "--json", "--config", file)
    found = json.loads(ended.out)
    assert (ended.status, ended.said, found["ok"]) == (2, "", False)
    assert [(error["line"], error["key"]) for error in found["errors"]] == [(2, "control.law"), (4, "reference.across")]
    assert "the nearest is 0.3598 m" in found["errors"][1]["message"]


def test_check_names_all_that_does_not_fit_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = written(
        tmp_path, "[control]\nagonist = 9\n[pretension]\ntension = 70.0\n[servo]\n[limits]\ndisplacement_rate = 2.0\n"
    )
    said = tendond(capsys, "config", "check", file).said
    for part in (
        f"{file}:2: control.agonist = 9, but the rod has tendons 0 to 3",
        f"{file}:4: pretension.tension and .antagonist together are above",
        f"{file}:7: limits.displacement_rate = 2 m/s is faster than the servos",
    ):
        assert part in said


@pytest.mark.parametrize("profile", PROFILES)
def test_check_has_nothing_against_the_profiles(profile: str, capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, "config", "check", "--profile", profile)
    assert (ended.status, ended.said) == (0, "")
    assert ": OK; " in ended.out


def test_check_notes_what_keeps_processes_from_running_but_is_not_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, WIRED_RIG + '[bus]\nendpoint = "tcp/0.0.0.0:7447"\n')
    ended = tendond(capsys, "config", "check", file)
    assert ended.status == 0
    assert f"note: {tmp_path / 'calibration.json'}: no such calibration" in ended.out
    assert "note: bus.endpoint = tcp/0.0.0.0:7447 is open to the network" in ended.out


@pytest.mark.parametrize("text", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
@pytest.mark.parametrize(("changed", "comments"), [(False, True), (True, True), (True, False), (False, False)])
def test_what_show_prints_reads_as_the_same_configuration(text: str, changed: bool, comments: bool) -> None:
    config = parse_config(text, "rig.toml")
    assert parse_config(config_toml(config, changed=changed, comments=comments), "shown") == config


OTHER = "[simulator.rod]\nlength = 0.5\n"


def test_show_of_the_changes_has_them_and_nothing_else() -> None:
    assert config_toml(RigConfig(), changed=True) == "# nothing differs from the defaults\n"
    assert "[servo]\n" in config_toml(parse_config("[servo]\n" + WIRED, "rig.toml"), changed=True, comments=False)
    shown = config_toml(parse_config("[rod]\nlength = 0.4\nradius = 1e-3", "rig.toml"), changed=True, comments=False)
    assert shown == "[rod]\nlength = 0.4\n"
    shown = config_toml(parse_config(f"[rod]\nlength = 0.4\n{OTHER}", "rig.toml"), changed=True, comments=False)
    assert shown == f"[rod]\nlength = 0.4\n\n{OTHER}"  # a default, but not what it would inherit


def test_show_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    whole = json.loads(tendond(capsys, "config", "show", "--profile", "paper", "--json").out)
    assert RigConfig.model_validate(whole) == parse_config(PROFILES["paper"], "paper")
    changed = json.loads(tendond(capsys, "config", "show", "--profile", "paper", "--changed", "--json").out)
    assert changed["rod"] == {"space": "euler", "nodes": 200}


def test_every_key_has_words_for_what_it_may_be() -> None:
    keys = [key for table in tables(RigConfig) for key in table.keys]
    assert len(keys) > 120
    assert all(key.words and key.words != "anything" for key in keys)
    assert all(key.meaning or key.unit for key in keys), [key.path for key in keys if not (key.meaning or key.unit)]


def test_the_schema_knows_every_key_and_the_laws_parameters() -> None:
    schema = config_schema()
    assert set(schema["properties"]) == set(RigConfig.model_fields) | {"version", "include"}
    laws = schema["$defs"]["ControlSection"]["properties"]
    assert laws["law"]["enum"] == list(LAWS)
    assert set(laws["laws"]["properties"]["backstepping"]["properties"]) == {"alpha1", "alpha2"}
    assert schema["additionalProperties"] is False


def test_lines_are_found_in_every_form_of_toml() -> None:
    text = """\
a.b = 1
[ c . d ]  # header
"e f" = [
  [1],
  [2],
]
last = "[not a header]"
[[c.g]]
h = 1
[c.g.i]
j = 1
"""
    lines = key_lines(text)
    assert lines["a", "b"] == 1
    assert lines["c", "d", "e f"] == 3
    assert lines["c", "d", "last"] == 7
    assert lines["c", "g", 0, "h"] == 9
    assert lines["c", "g", 0, "i", "j"] == 11
    assert line_of(("c", "d", "nothing", 2), lines) == 2
    assert line_of(("nowhere",), lines) is None


@pytest.mark.parametrize(("tension_max", "noted"), [(100.0, False), (300.0, True)])
def test_check_notes_a_bend_that_the_nodes_do_not_resolve(
    tension_max: float, noted: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The public example's steel rod: 69 mm off at 300 N with six nodes, exact to 0.1 mm at 100 N."""
    offset = 0.01506
    rod = (
        "[rod]\nlength = 0.5\nradius = 0.001\nyoungs_modulus = 200e9\npoisson_ratio = 0.25\ndensity = 8000.0\n"
        f"tendon_positions = [[{offset}, 0.0], [0.0, {offset}], [-{offset}, 0.0], [0.0, -{offset}]]\n"
    )
    ended = tendond(capsys, "config", "check", written(tmp_path, f"{rod}[limits]\ntension_max = {tension_max}\n"))
    assert ended.status == 0
    assert ("note: rod.nodes (by default): at limits.tension_max = 300 N" in ended.out) is noted


ARM = '[rod]\npreset = "rao-2021"\n'


def test_a_base_away_from_the_world_is_accepted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    moved = f"{ARM}[rod.base]\nposition = [0.1, 0.0, 0.0]\n[reference]\nacross = 0.1\n"
    ended = tendond(capsys, "config", "check", "--config", written(tmp_path, moved))
    assert ended.status == 0


def test_a_study_takes_sections_and_names_what_they_cannot_reach(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, "study", "margin", "--config", written(tmp_path, ARM))
    assert ended.status == 1
    assert ended.said.count("\n") == 1
    assert "reference.across = 0.34 (the default) is beyond what the rod can reach" in ended.said


def test_an_arm_of_two_sections_is_checked_as_the_controller_runs_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task = "[reference]\nacross = 0.12\n[limits]\ntension_max = 8.0\n[control]\nlaw = 'sensitivity'\n"
    ended = tendond(capsys, "config", "check", written(tmp_path, ARM + task))
    assert ended.status == 0, ended.said
    assert "OK; rig 'paper', law sensitivity, 100 Hz, 6 tendons" in ended.out


def test_check_prints_the_robot_and_as_json_its_figures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shown = tendond(capsys, "config", "check").out
    assert "robot: 1 section, 500 mm, 27 g, 4 tendons\n" in shown
    assert "natural frequencies (damping ratio): 3.73 Hz (0.63)" in shown
    found = json.loads(tendond(capsys, "config", "check", "--json", "--config", written(tmp_path, ARM)).out)
    assert not found["ok"]
    assert found["robot"]["mass_kg"] == pytest.approx(2 * (0.2 * 0.0115 + 10 * 2e-4))


def test_a_preset_is_printed_as_a_configuration_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    shown = parse_config(tendond(capsys, "config", "show", "--preset", "rao-2021").out, "shown")
    expected = parse_config(ARM, "rig.toml").rod.model_copy(update={"preset": None})
    assert shown.rod == expected
    refused = tendond(capsys, "config", "show", "--preset", "rao")
    assert "unknown preset 'rao': choose one of paper, nitinol" in refused.said


def test_the_example_of_sections_is_checked_with_its_own_law(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (Path(__file__).parents[3] / "docs" / "howto" / "sections.md").read_text()
    example = page.partition("```toml\n")[2].partition("```")[0]
    ended = tendond(capsys, "config", "check", written(tmp_path, example))
    assert ended.status == 0, ended.said
    assert "law sensitivity" in ended.out
    far = example.replace("0.37]", "0.9]")
    assert far != example
    ended = tendond(capsys, "config", "check", written(tmp_path, far))
    assert ended.status == 2
    assert "reference" in ended.said
