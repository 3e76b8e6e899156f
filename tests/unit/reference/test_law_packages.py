"""Laws of other packages: found by their entry points, with parameters of any type and a state in log and snapshot."""

import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.daemon.control.laws import LAWS, select_law
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState
from tendond.daemon.errors import LawError, LawPackageError
from tendond.drivers.simulator.lockstep import watched_loop, without_probe
from tendond.offline.logs import load
from tendond.offline.replay.offline import record_lockstep
from tendond.offline.replay.rerun import rerun
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "howto" / "law.md").read_text(encoding="utf-8")
CONFIG = '[control]\nlaw = "leaky_integral"\n[control.laws.leaky_integral]\nintegrated = "across"\nintegral = 3\n'


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def install(site: Path, module: str, code: str, entries: dict[str, str], name: str = "my-laws") -> None:
    """Install a package as pip leaves it: its module, and its metadata with the entry points."""
    site.mkdir(exist_ok=True)
    (site / f"{module}.py").write_text(code, encoding="utf-8")
    info = site / f"{name.replace('-', '_')}-0.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1\n", encoding="utf-8")
    lines = "".join(f"{key} = {value}\n" for key, value in entries.items())
    (info / "entry_points.txt").write_text(f"[tendond.laws]\n{lines}", encoding="utf-8")


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on the path for packages; laws are looked for anew before and after."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    modules = set(sys.modules)
    LAWS.forget()
    yield folder
    for name in set(sys.modules) - modules:
        if str(getattr(sys.modules[name], "__file__", "")).startswith(str(folder)):
            del sys.modules[name]
    LAWS.forget()


def install_from_page(site: Path) -> None:
    entries = tomllib.loads(block("toml"))["project"]["entry-points"]["tendond.laws"]
    install(site, "my_laws", block("python"), entries)


def run(config: RigConfig, cycles: int = 250) -> tuple[list[CycleState], Mode, float]:
    """States, last mode and last distance across from the target [m]."""
    states: list[CycleState] = []
    for watched in watched_loop(config, cycles, {5: ControlAction.ARM}, see_state=states.append):
        record = watched.record
    assert record.measured is not None
    return states, record.mode, abs(record.measured[0] - record.reference.target[0])


def test_the_law_of_the_page_is_found_in_its_package_and_tracks(site: Path) -> None:
    install_from_page(site)
    assert "leaky_integral" in LAWS
    law, parameters = select_law("leaky_integral", {"leaky_integral": {"integrated": "across", "integral": 3}})
    assert (parameters.integrated, parameters.integral, law.name) == ("across", 3.0, "leaky_integral")
    states, mode, distance = run(parse_config(CONFIG, "test"))
    assert mode is Mode.TRACKING
    assert distance < 1e-3
    assert states[10].law_state is None  # not tracking yet
    assert states[-1].law_state is not None
    assert states[-1].law_state.value.integral[0] != 0.0


def test_the_state_of_a_law_is_in_the_snapshots_and_a_run_goes_on_from_one(site: Path, tmp_path: Path) -> None:
    install_from_page(site)
    config = parse_config(CONFIG, "test")
    states, _, _ = run(config)
    setup = CycleSetup.from_config(config)
    text = encode_state(states[-1])
    again = decode_state(CycleState, text, setup)
    assert again.law_state == states[-1].law_state
    assert encode_state(again) == text
    log = tmp_path / "run.mcap"
    record_lockstep(CycleSetup.from_config(without_probe(config)), 250, {5: ControlAction.ARM}, log)
    outcome = rerun(log, first=150, jobs=1)
    assert (outcome.compared, outcome.first) == (100, None)
    assert load(log)["law_state.integral"].shape == (250, 2)


def test_parameters_of_a_dataclass_are_checked_by_key(site: Path) -> None:
    install_from_page(site)
    with pytest.raises(LawError, match=r"control\.laws\.leaky_integral\.integrated = "):
        select_law("leaky_integral", {"leaky_integral": {"integrated": "along"}})
    with pytest.raises(LawError, match=r"control\.laws\.leaky_integral\.frequency = "):
        select_law("leaky_integral", {"leaky_integral": {"frequency": "fast"}})


@pytest.mark.parametrize(
    ("code", "entries", "said"),
    [
        ("LAW = 1 / 0", {"broken": "broken_law:LAW"},
         r"law 'broken' of package my-laws cannot be imported from broken_law:LAW: ZeroDivisionError: division"),
        ("LAW = 1", {"broken": "broken_law:LAW"}, r"is not a law: broken_law:LAW has no name, parameters"),
        ("from tendond.daemon.control.laws.backstepping import LAW", {"other": "broken_law:LAW"},
         r"calls itself 'backstepping'"),
        ("from tendond.daemon.control.laws.backstepping import LAW", {"backstepping": "broken_law:LAW"},
         r"package my-laws brings a law 'backstepping', and there is one of that name already"),
    ],
)  # fmt: skip
def test_a_package_that_cannot_be_used_is_refused_by_name_with_the_remedy(
    site: Path, code: str, entries: dict[str, str], said: str
) -> None:
    install(site, "broken_law", code, entries)
    with pytest.raises(LawPackageError, match=said) as found:
        len(LAWS)
    assert "\n" not in str(found.value)
    assert "uninstall the package" in str(found.value)


def test_a_command_ends_with_one_line_and_exit_status_2_where_a_law_cannot_be_imported(tmp_path: Path) -> None:
    site = tmp_path / "site"
    install(site, "broken_law", "import no_such_module", {"broken": "broken_law:LAW"})
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), str(ROOT)])}
    done = subprocess.run(
        [sys.executable, "-m", "tendond", "config", "check"], env=environment, capture_output=True, text=True,
        timeout=120, check=False,
    )  # fmt: skip
    (line,) = done.stderr.strip().splitlines()
    assert "law 'broken' of package my-laws cannot be imported" in line
    assert done.returncode == 2
