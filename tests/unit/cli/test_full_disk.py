"""A disk that is full while a command writes: one line, and nothing half-written under the final name."""

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from tendond.offline.files import whole, write_whole
from tests.unit.cli.test_unusable_files import FAULTS, NORMAL

LARGEST = 2000
"""Largest file that a process may write [bytes]: a process meets it as it meets a full disk."""


def limited(*words: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Run a command whose files may not grow; its output goes to pipes, which do not count."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST, LARGEST))

    return subprocess.run(
        [sys.executable, "-m", "tendond", *words], capture_output=True, text=True, cwd=folder, preexec_fn=limit
    )


@pytest.mark.parametrize(
    "words",
    [
        f"plot {NORMAL} --out plots",
        f"plot {NORMAL} --out plots --format html",
        f"log report {NORMAL} --out run.html",
        f"log export {NORMAL} --out run.csv",
        f"log export {NORMAL} --out run.parquet",
        f"log compare {NORMAL} {FAULTS} --out compared",
        f"log recover {NORMAL} --out whole.mcap",
        f"log what-if {NORMAL} --law sliding_mode --out other.mcap",
    ],
    ids=lambda words: " ".join(word for word in words.split() if word.isalpha()),
)
def test_a_full_disk_is_a_line_and_leaves_nothing_half_written(words: str, tmp_path: Path) -> None:
    if "parquet" in words:
        pytest.importorskip("pyarrow")
    found = limited(*words.split(), folder=tmp_path)
    assert found.returncode in (1, 2), found
    said = found.stderr.splitlines()
    assert "Traceback" not in found.stderr
    assert all(line.startswith("tendond: ") for line in said), said
    assert "File too large" in said[-1] or "not whole" in said[-1], said
    assert [path for path in tmp_path.rglob("*") if path.is_file() and path.stat().st_size >= LARGEST] == []
    assert {path.suffix for path in tmp_path.rglob("*") if path.is_file()} <= {".csv"}  # a table that was small enough
    assert "run.csv" not in os.listdir(tmp_path)


@pytest.mark.parametrize("words", [f"log report {NORMAL} --out /dev/full"])
def test_a_device_is_written_itself_and_stays(words: str, tmp_path: Path) -> None:
    found = subprocess.run(
        [sys.executable, "-m", "tendond", *words.split()], capture_output=True, text=True, cwd=tmp_path
    )
    assert found.returncode == 1
    assert found.stderr == "tendond: /dev/full: No space left on device; choose another path with --out\n"
    assert Path("/dev/full").is_char_device()
    assert not Path("/dev/.full.part").exists()


def test_a_file_is_replaced_at_the_end_only(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text("old")

    def half() -> None:
        with whole(file) as draft:
            draft.write_text("half")
            assert draft.suffix == ".csv"
            raise ValueError("defect")

    with pytest.raises(ValueError, match="defect"):
        half()
    assert (file.read_text(), os.listdir(tmp_path)) == ("old", ["table.csv"])
    write_whole(file, "new")
    assert (file.read_text(), os.listdir(tmp_path)) == ("new", ["table.csv"])


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "link.txt").symlink_to(tmp_path / "there" / "file.txt")
    write_whole(tmp_path / "link.txt", "new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "there" / "file.txt").read_text() == "new"


def test_an_error_without_a_name_is_given_the_files(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No space") as caught, whole(tmp_path / "figure.png"):
        raise OSError(28, "No space left on device")
    assert caught.value.filename == str(tmp_path / "figure.png")
