"""The folder of a trial: none is lost."""

from pathlib import Path

import pytest

from tendond.cli.trying.run import trial_folder
from tendond.daemon.errors import DaemonError


def test_the_next_trial_goes_beside_the_one_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for expected in ("out/try-arm", "out/try-arm-2", "out/try-arm-3"):
        folder = trial_folder(None, "arm", force=False)
        assert folder == Path(expected)
        folder.mkdir(parents=True)
    assert trial_folder(None, "arm", force=True) == Path("out/try-arm")


def test_a_trial_in_the_folder_that_is_named_is_replaced_only_when_asked(tmp_path: Path) -> None:
    assert trial_folder(tmp_path, "arm", force=False) == tmp_path, "other files are in nobody's way"
    (tmp_path / "try.mcap").write_bytes(b"a log")
    with pytest.raises(DaemonError, match=r"try\.mcap: a trial is there already; --force replaces it"):
        trial_folder(tmp_path, "arm", force=False)
    assert trial_folder(tmp_path, "arm", force=True) == tmp_path
    assert (tmp_path / "try.mcap").read_bytes() == b"a log"
