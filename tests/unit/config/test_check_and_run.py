"""`config check` accepts what `run` and `simulate` accept, and nothing else: verdicts beside each other."""

import re
from pathlib import Path

import pytest

from tendond import TendondError
from tendond.cli.common import load_config
from tendond.cli.config.check import run_check
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.runtime.warm_up import warm_up
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import plant_rod
from tendond.model.errors import ModelError
from tendond.schemas.config.presets import PROFILES, SPACE, WIRED, WIRED_SPACE
from tendond.schemas.config.rod.presets import PRESETS
from tests.unit.cli.test_documents import ROOT, blocks

GENERAL = SPACE.replace('law = "sensitivity"', 'law = "sensitivity"\nsolver = "general"')
CASES = {
    **{f"profile {name}": text for name, text in PROFILES.items()},
    "demo wired": WIRED,
    "demo spatial": SPACE,
    "demo spatial, wired": WIRED_SPACE,
    "demo spatial, on the general rod": GENERAL,
    **{f"preset {name}": f'[rod]\npreset = "{name}"\n' for name in PRESETS},
    **{f"preset {name}, near": f'[rod]\npreset = "{name}"\n[reference]\nacross = 0.1\n' for name in PRESETS},
    **{str(path.relative_to(ROOT)): path.read_text() for path in ROOT.glob("deploy/**/*.toml")},
    **{str(path.relative_to(ROOT)): path.read_text() for path in ROOT.glob("examples/**/*.toml")},
    **{
        f"{path.relative_to(ROOT)} {number}": text
        for number, (path, text) in enumerate(blocks("toml"))
        if "[project]" not in text
    },
    "mpc with a tool": '[control]\nlaw = "mpc"\n[rod]\ntip_mass = 0.05\n',
    "sensitivity with a tool": '[control]\nlaw = "sensitivity"\n[rod]\ntip_mass = 0.05\n',
    "a filter on the shooting rod": '[observer]\nkind = "kalman"\n',
    "a law's parameter": "[control.laws.sliding_mode]\nk = -1\n",
    "strong servos": "[limits]\ntension_max = 400.0\n",
}


def verdict_of_run(file: Path) -> str:
    """Set up controller and simulator as their commands do, without the bus; empty, or what is refused."""
    try:
        config = load_config(file)
        warm_up(CycleSetup.from_config(config))
        Plant(config, plant_rod(config.simulator, config.simulator.period)).step(None)
    except (TendondError, ModelError) as error:
        return str(error)
    return ""


def verdict_of_check(file: Path) -> str:
    try:
        run_check(file, None, as_json=False)
    except TendondError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", CASES)
def test_check_accepts_what_run_accepts(name: str, tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(CASES[name])
    run, check = verdict_of_run(file), verdict_of_check(file)
    assert bool(run) is bool(check), (run, check)
    said = re.sub(r"^[^\n]*?rig\.toml(:\d+)?: ", "", check)
    assert not run or said.startswith(re.sub(r"^[^\n]*?rig\.toml: ", "", run).splitlines()[0]), (run, check)


def test_there_are_cases_of_both_verdicts_in_the_project() -> None:
    assert len(CASES) > 30
    assert any(name.startswith("deploy/") for name in CASES)
    assert any(name.startswith("docs/space.md") for name in CASES)
