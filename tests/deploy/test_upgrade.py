"""A version installed over another one, and the one before over that: configurations, logs and units are in order."""

import hashlib
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond import __version__
from tendond.daemon.recording.mcap_file import McapFile
from tendond.daemon.recording.run_files import CONFIG
from tendond.daemon.recording.storage.run_notes import RunNotes, notes_path, write_notes
from tendond.schemas.config.migration.version import CONFIG_VERSION
from tendond.schemas.config.rig import RigConfig
from tests.deploy.installation import ROOT, Installation, build

NEXT = "99.0.0"
UNIT = "usr/local/lib/systemd/system/tendond-controller@.service"
OLD_KEYS = '[rig]\nname = "old"\n\n[loop]\nrehearse = false  # a slow machine\n'


def later_version(source: Path, folder: Path) -> Path:
    """A copy of a source distribution as a later version: with another unit, and another version of configurations."""
    copy = folder / "later"
    shutil.copytree(source, copy, symlinks=True)
    init = copy / "tendond" / "__init__.py"
    init.write_text(init.read_text().replace(f'"{__version__}"', f'"{NEXT}"'))
    unit = copy / "deploy" / "systemd" / "tendond-controller@.service"
    unit.write_text(unit.read_text().replace("WatchdogSec=5", "WatchdogSec=6"))
    version = copy / "tendond" / "schemas" / "config" / "migration" / "version.py"
    line, other = (f"CONFIG_VERSION = {number}\n" for number in (CONFIG_VERSION, CONFIG_VERSION + 1))
    assert line in version.read_text()
    version.write_text(version.read_text().replace(line, other))
    return copy


def state(root: Path) -> dict[str, str]:
    """Content of everything that an installation must never change, by path."""
    folders = [root / "etc" / "tendond", root / "var" / "log" / "tendond"]
    files = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def units(one: Installation) -> dict[str, str]:
    """Units that are installed, and those of the source, by name; the same if all is in order."""
    folder = one.root / "usr/local/lib/systemd/system"
    return {path.name: path.read_text() for path in sorted(folder.iterdir())}


def units_of(source: Path) -> dict[str, str]:
    names = ("tendond-controller@.service", "tendond-servo@.service", "tendond-vicon@.service", "tendond@.target")
    return {name: (source / "deploy" / "systemd" / name).read_text() for name in names}


@pytest.fixture(scope="module")
def versions(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Installation, Installation]]:
    """This version installed with two rigs that have logs; and a later one that goes to the same place."""
    folder = tmp_path_factory.mktemp("upgrade")
    built = build(folder)
    root = folder / "root"
    now = Installation(built.source, built.wheel, root)
    assert now.install().returncode == 0
    second = folder / "second"
    second.mkdir()
    source = later_version(built.source, second)
    (second / "dist").mkdir()
    later = Installation(source, build(second / "dist", source).wheel, root)
    rig = root / "etc/tendond/old"
    rig.mkdir()
    (rig / "rig.toml").write_text(OLD_KEYS)
    logs = root / "var/log/tendond/bench"
    logs.mkdir()
    McapFile(logs / "bench-20260101T000000Z.mcap", {"rig": "bench"}, {CONFIG: RigConfig().model_dump_json()}).finish()
    write_notes(notes_path(logs, "bench-20260101T000000Z"), RunNotes(tags=("demo",)))
    yield now, later
    shutil.rmtree(folder)


def check(one: Installation, version: str, before: dict[str, str]) -> None:
    """Check that one version is there, whole and alone, and that nothing of the rigs has changed."""
    assert one.tendond("--version").stdout == f"tendond {version}\n"
    assert units(one) == units_of(one.source)
    assert state(one.root) == before
    assert [path.name for path in (one.root / "opt").iterdir()] == ["tendond"], "nothing half installed is left"
    logs = one.root / "var/log/tendond/bench"
    assert "intact" in one.tendond("log", "verify", str(logs)).stdout
    listed = one.tendond("log", "list", str(logs), "--tag", "demo", "--json").stdout
    assert '"run": "bench-20260101T000000Z"' in listed
    (logs / ".tendond-index.json").unlink()


def test_up_and_down_again_all_is_in_order_and_a_migrated_configuration_goes_back_by_its_copy(
    versions: tuple[Installation, Installation],
) -> None:
    now, later = versions
    before = state(now.root)
    assert len(before) == 6
    check(now, __version__, before)

    result = later.install()
    assert result.returncode == 0, result.stderr
    check(later, NEXT, before)
    file = now.root / "etc/tendond/old/rig.toml"
    assert f"tendond config migrate {file} --write" in result.stdout
    result = later.tendond("config", "migrate", str(file), "--write")
    assert result.returncode == 0, result.stderr
    assert "speculate = false  # a slow machine" in file.read_text()

    result = now.install()
    assert result.returncode == 0, result.stderr
    assert re.search(r"install: REFUSED: .*old/rig\.toml:1: version = .*upgrade tendond", result.stdout)
    file.with_name("rig.toml.v1").replace(file)
    check(now, __version__, before)
    assert now.tendond("config", "check", "--no-model", str(file)).returncode == 0


def test_an_installation_that_fails_leaves_the_version_before_as_it_is(
    versions: tuple[Installation, Installation], tmp_path: Path
) -> None:
    now, later = versions
    before = state(now.root), units(now), now.tendond("--version").stdout
    broken = tmp_path / "broken-1.0-py3-none-any.whl"
    broken.write_text("no wheel")
    assert Installation(later.source, broken, later.root).install().returncode != 0
    assert (state(now.root), units(now), now.tendond("--version").stdout) == before


def test_the_later_version_is_not_the_one_that_is_tested(versions: tuple[Installation, Installation]) -> None:
    """Else nothing above would say anything."""
    now, later = versions
    assert "WatchdogSec=6" in (later.source / "deploy/systemd/tendond-controller@.service").read_text()
    assert "WatchdogSec=5" in (now.root / UNIT).read_text()
    assert (ROOT / "deploy/install").read_text() == (later.source / "deploy/install").read_text()
