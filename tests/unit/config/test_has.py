"""`tendond config has`, the condition of the drivers' units."""

from pathlib import Path

import pytest

from tests.unit.cli.commands import tendond


@pytest.mark.parametrize(
    ("text", "section", "status"),
    [
        ("[vicon]\n", "vicon", 0),
        ('[mocap]\nsystem = "optitrack"\n', "vicon", 0),
        ("[servo]\n", "vicon", 1),
        ("[vicon]\n", "mocap", 1),
        ("[mocap]\n", "servo", 1),
    ],
)
def test_the_unit_of_the_cameras_runs_where_a_file_has_mocap_or_vicon(
    text: str, section: str, status: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(text)
    assert tendond(capsys, "config", "has", section, str(file)).status == status
