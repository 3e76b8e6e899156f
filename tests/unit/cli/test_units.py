"""Values in millimetres or grams are refused, with the unit and what may have been meant."""

from pathlib import Path

import pytest

from tendond.cli.rig.operator import check_lengths, check_rows
from tendond.daemon.errors import UsageError
from tendond.offline.identification.recordings.weights import parse_weights
from tendond.schemas.mistaken_units import unit_hint
from tests.unit.cli.commands import tendond


@pytest.mark.parametrize(
    "setting",
    ["moved_max=10", "across=300", "position=[340.0,0.0,47.5]", "radius=250", "start=[-200,0]", "radius_end=5"],
)
@pytest.mark.parametrize("command", [["rig", "reference"], ["rig", "teach", "play", "{}/path.csv"]])
def test_a_reference_in_millimetres_is_refused_with_the_unit(
    setting: str, command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "path.csv").write_text("t,x,z\n0,0.0,0.5\n1,0.1,0.4\n")
    ended = tendond(capsys, *(word.format(tmp_path) for word in command), setting)
    assert ended.status == 2
    assert ended.said.startswith(f"tendond: reference: {setting.split('=')[0]} = ")
    assert "which is 0.5 m long; lengths are in metres" in ended.said


def test_a_hint_says_what_may_have_been_meant() -> None:
    assert unit_hint(300.0, 1.0, "m") == "; lengths are in metres: did you mean 0.3?"
    assert unit_hint(3e6, 1.0, "m") == "; lengths are in metres"
    assert unit_hint(50.0, 10.0, "kg") == "; masses are in kilograms: did you mean 0.05?"
    assert unit_hint(50.0, 10.0, "N") == ""


def test_lengths_that_an_arm_can_have_and_angles_are_taken() -> None:
    check_lengths({"moved_max": 0.5, "across": -0.34, "kind": "step", "start": [-0.2, 0.0], "rate": 300.0}, 0.5)
    check_lengths({"aim": "direction", "radius": 1.2, "start": [1.1, 0.0], "speed_max": 20.0}, 0.5)
    check_lengths({"no_such_key": 1e9}, 0.5)


def test_a_file_in_millimetres_is_refused_with_its_line() -> None:
    check_rows(Path("path.csv"), {"samples": [(0.0, 0.1, 0.4), (2000.0, 0.2, 0.3)]}, 0.5)
    check_rows(Path("path.csv"), {"samples": [(0.0, 0.1, 0.0, 0.4, 0.0, 0.0, 1.0)]}, 0.5)
    with pytest.raises(UsageError, match=r"path.csv:3: 400 m is out of .*did you mean 0.4\?"):
        check_rows(Path("path.csv"), {"samples": [(0.0, 0.1, 0.4), (1.0, 100.0, 400.0)]}, 0.5)
    with pytest.raises(UsageError, match=r"path.csv:2: 400 m"):
        check_rows(Path("path.csv"), {"waypoints": [(0.0, 100.0, 400.0)]}, 0.5)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("rig inject weight --size 50", "weight takes at most 10 kg; masses are in kilograms: did you mean 0.05?"),
        ("rig inject teleport --size 100", "teleport takes at most 10 m; lengths are in metres: did you mean 0.1?"),
        ("validate own.csv --length 300 --radius 0.01", "--length: must be less than or equal to 10 m; see"),
        ("identify run --weight 50", "--weight: must be less than or equal to 10 kg; see"),
        ("servo identify 0 --travel 0.006", "--travel: must be greater than or equal to 1 mm; see"),
    ],
)
def test_an_option_out_of_range_names_its_unit(words: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, *words.split())
    assert (ended.status, ended.out) == (2, "")
    assert said in ended.said


def test_a_weight_in_grams_is_refused() -> None:
    assert parse_weights(["loaded.mcap=0.05"]) == {"loaded.mcap": 0.05}
    with pytest.raises(UsageError, match=r"0 to 10 kg.*did you mean 0.05\?"):
        parse_weights(["loaded.mcap=50"])
