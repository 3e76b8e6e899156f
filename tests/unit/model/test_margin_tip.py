"""A configured body on the tip: the laws settle with the heaviest that they are allowed, and are refused beyond."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tendond.cli.app import app
from tendond.daemon.control import selection as selection_module
from tendond.daemon.control.laws import SPACE
from tendond.daemon.control.tasks import space as space_module
from tendond.daemon.control.tasks.space import tip_mass_within_cycle
from tendond.daemon.errors import LawError, TargetError
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.rods.selection import model_rod, rod_from_section
from tendond.schemas.config.rig import RigConfig, check_config, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction


def with_configured_tip(law: str, mass: float, rate: float, delay: int = 0) -> RigConfig:
    """A rig whose model and plant have the same body on the tip [kg], at a rate [Hz] and with a delay [cycles]."""
    return parse_config(
        f'[rod]\ntip_mass = {mass}\n[simulator.rod]\ntip_mass = {mass}\n[control]\nlaw = "{law}"\n'
        f"[loop]\nperiod = {1.0 / rate}\n[simulator]\nperiod = {1.0 / rate}\n"
        f"[simulator.mocap]\nlatency = {delay / rate}\n[observer]\ndelay = {delay / rate}\n",
        "tip",
    )


def end_of(config: RigConfig, seconds: float = 8.0) -> tuple[Mode, float]:
    """Mode at the end of a run, and the true tip's largest peak to peak in its last second [m]."""
    rate = round(1.0 / config.loop.period)
    tips, mode = [], Mode.STARTING
    for watched in watched_loop(config, round(seconds * rate), {rate: ControlAction.ARM}):
        mode = watched.record.mode
        tips.append(watched.truth.position)
    return mode, float(np.max(np.ptp(np.array(tips[-rate:]), axis=0)))


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
@pytest.mark.parametrize("delay", [0, 2])
def test_the_law_in_space_settles_with_the_heaviest_tip_that_it_is_allowed(rate: float, delay: int) -> None:
    config = with_configured_tip("sensitivity", 0.0, rate)
    bound = SPACE.tip_mass_max(config, rod_from_section(config.rod, config.loop.period).parameters)
    mode, ripple = end_of(with_configured_tip("sensitivity", bound, rate, delay))
    assert mode is Mode.TRACKING
    assert ripple < 0.2e-3


@pytest.mark.parametrize(("rate", "mass"), [(50.0, 0.01), (100.0, 0.02), (100.0, 0.1), (250.0, 0.035)])
def test_the_law_in_space_is_refused_where_it_would_swing(
    rate: float, mass: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = with_configured_tip("sensitivity", mass, rate)
    with pytest.raises(
        LawError, match=r"swings the arm with .* kg on the tip .* bears 0 to .* set control\.solver = \"general\""
    ):
        end_of(config)
    monkeypatch.setattr(selection_module, "tip_objection", lambda config, rod, law: "")
    mode, _ = end_of(config)
    assert mode is Mode.FAULT


def on_the_general_rod(mass: float) -> RigConfig:
    """The same at 100 Hz on the general rod, with a target near the straight rod: farther ones forgive more."""
    config = with_configured_tip("sensitivity", mass, 100.0).model_dump()
    config["control"]["solver"] = config["simulator"]["solver"] = "general"
    config["reference"]["across"] = 0.1
    return check_config(config, "tip")


def test_the_general_rod_settles_with_the_heaviest_tip_too() -> None:
    config = on_the_general_rod(0.0)
    bound = tip_mass_within_cycle(config, model_rod(config).parameters)
    mode, ripple = end_of(on_the_general_rod(0.97 * bound), 4.0)  # a heavier rod stands for the robot with the mass
    assert mode is Mode.TRACKING
    assert ripple < 0.2e-3


@pytest.mark.parametrize("mass", [0.02, 0.1])
def test_beyond_it_the_law_moves_the_general_rod_along_its_rests(mass: float, monkeypatch: pytest.MonkeyPatch) -> None:
    config = on_the_general_rod(mass)
    mode, ripple = end_of(config, 6.0)
    assert mode is Mode.TRACKING
    assert ripple < 0.2e-3
    monkeypatch.setattr(space_module, "by_rests", lambda config, rod: False)
    mode, ripple = end_of(config, 3.0)
    assert mode is Mode.FAULT or ripple > 0.1


@pytest.mark.parametrize("solver", ["shooting", "general"])
@pytest.mark.parametrize(
    "own", [{"youngs_modulus": 414e9}, {"tendon_positions": [[0.01, 0], [0, 0.01], [-0.01, 0], [0, -0.01]]}]
)
def test_robots_that_need_twice_the_tension_settle_with_their_heaviest_tip(solver: str, own: dict[str, object]) -> None:
    rig = {
        "control": {"law": "sensitivity", "solver": solver}, "simulator": {"solver": solver},
        "limits": {"tension_max": 120.0}, "reference": {"across": 0.2},
    }  # fmt: skip
    free = check_config({**rig, "rod": own}, "free")
    mass = 0.97 * tip_mass_within_cycle(free, model_rod(free).parameters)
    assert mass > 2e-3
    mode, ripple = end_of(check_config({**rig, "rod": {**own, "tip_mass": mass}}, "tip"), 4.0)
    assert mode is Mode.TRACKING
    assert ripple < 0.3e-3


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
@pytest.mark.parametrize("rate", [100.0, 250.0])
def test_the_papers_laws_settle_with_a_hundred_grams_in_the_model(law: str, rate: float) -> None:
    mode, ripple = end_of(with_configured_tip(law, 0.1, rate))
    assert mode is Mode.TRACKING
    assert ripple < 0.2e-3


def test_config_check_names_a_tip_that_the_law_does_not_bear(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text('[rod]\ntip_mass = 0.02\n[control]\nlaw = "sensitivity"\n', encoding="utf-8")
    result = CliRunner().invoke(app, ["config", "check", str(file)])
    assert result.exit_code != 0
    assert "rig.toml:4: control.law: sensitivity swings the arm with 0.02 kg on the tip" in str(result.exception)
    file.write_text("[rod]\ntip_mass = 0.02\n", encoding="utf-8")
    assert CliRunner().invoke(app, ["config", "check", str(file)]).exit_code == 0


@pytest.mark.parametrize(("disks", "weak"), [(0, 5.8), (3, 6.0)])
def test_a_tool_and_disks_are_borne_by_rests(disks: int, weak: float) -> None:
    section: dict[str, object] = {"length": 0.25, "radius": 6e-4, "youngs_modulus": 60e9, "density": 6450.0}
    if disks:
        section |= {"disk_number": disks, "disk_mass": 1e-3, "disk_radius": 0.01, "disk_thickness": 0.003}
    tendons = [{"position": [0.008 * x, 0.008 * y]} for x, y in ((1.0, 0.0), (-0.5, 0.866), (-0.5, -0.866))]
    rod = {"section": [section], "tendon": tendons, "tip": {"mass": 0.015}, "damping_ratio": 0.02}
    rig = {"rod": rod, "limits": {"tension_max": 8.0}, "reference": {"across": 0.08}}
    config = check_config({**rig, "commissioning": {"rest": False, "probe": False}}, "test")
    assert config.control.law == "sensitivity"
    mode, ripple = end_of(config, 5.0)
    assert mode is Mode.TRACKING
    assert ripple < 0.5e-3
    less = check_config({**config.model_dump(mode="json"), "limits": {"tension_max": weak}}, "weak")
    with pytest.raises(
        TargetError, match=f"mm beyond where the tip can rest with every tendon between 1 and {weak:g} N"
    ):
        end_of(less, 1.0)
