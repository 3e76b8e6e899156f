"""Identification from plan to parameter file, with short logs of the real controller on the simulator."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tendond.cli.app import app
from tendond.cli.common import load_config
from tendond.daemon.errors import UsageError
from tendond.offline.identification.excitation.dry_run import dry_run, rig_of_model
from tendond.offline.identification.excitation.plan import PlanError, Request, propose, proposed_weight
from tendond.offline.identification.proof.prove import ProofOutcome, coverage, met
from tendond.offline.identification.proof.rigs import ProofTask, truth
from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.identification.recordings.recording import DataError
from tendond.offline.identification.recordings.weights import parse_weights
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.simulator import Weight
from tendond.schemas.requests import ControlAction
from tests.unit.offline.records import cycle_record, write_log

BASE = {
    "rod": {"tendon_stiffness": 2e4},
    "limits": {"displacement_min": -0.08, "displacement_max": 0.08, "displacement_rate": 0.085, "slack": 0.001},
    "observer": {"delay": 0.01},
}
SIMULATOR = {
    "period": 0.005,
    "drive": "displacement",
    "rod": {"tendon_stiffness": 1.8e4, "youngs_modulus": 1.75e11, "density": 18000.0},
    "servo": {"lag": 0.02},
    "mocap": {"noise": 1e-4, "latency": 0.01, "period": 0.01},
}


def config_with(weight: float = 0.0) -> RigConfig:
    return check_config({**BASE, "simulator": {**SIMULATOR, "weight": {"mass": weight}}}, "test")


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A log without and one with a weight of 40 g, which it knows of itself."""
    folder = tmp_path_factory.mktemp("logs")
    free, weighted = folder / "free.mcap", folder / "weighted.mcap"
    plan = propose(config_with(), ("sway",), 0.7)
    dry_run(config_with(), replace(plan, requests=plan.requests[:3], duration=plan.parts[1][0]), free)
    plan = propose(config_with(0.04), ("steps",), 0.4)
    dry_run(config_with(0.04), replace(plan, duration=5.0), weighted, {"weight": "0.04"})
    return free, weighted


def test_a_recording_is_the_log_from_its_rest_on(logs: tuple[Path, Path]) -> None:
    free, weighted = (load_recording(path, {}) for path in logs)
    assert free.times[0] == 0.0
    assert np.allclose(np.diff(free.times), 0.01)
    assert free.noise == pytest.approx(1e-4, rel=0.2)
    assert free.has_reports
    assert not free.armed[0]
    assert free.armed.any()
    assert free.weight == 0.0
    assert weighted.weight == 0.04
    assert load_recording(logs[1], {"weighted.mcap": 0.03}).weight == 0.03


def test_a_log_in_which_the_arm_never_rests_is_refused(tmp_path: Path) -> None:
    moving = [cycle_record(tick, measured=(0.005 * tick, 0.0, 0.4), displacement=0.001 * tick) for tick in range(80)]
    with pytest.raises(DataError, match="never at rest"):
        load_recording(write_log(tmp_path / "moving.mcap", moving), {})
    blind = write_log(tmp_path / "blind.mcap", [one.model_copy(update={"pose_age": None}) for one in moving])
    with pytest.raises(DataError, match="has no pose"):
        load_recording(blind, {})


def test_weights_are_given_by_log() -> None:
    assert parse_weights(["a.mcap=0.05", "b=c.mcap=0"]) == {"a.mcap": 0.05, "b=c.mcap": 0.0}
    for wrong in ("0.05", "a.mcap=heavy", "a.mcap=-1", "=0.05", "a.mcap=11"):
        with pytest.raises(UsageError, match="give LOG=KG"):
            parse_weights([wrong])


def test_the_command_leaves_a_file_that_a_configuration_includes(logs: tuple[Path, Path], tmp_path: Path) -> None:
    arguments = ["identify", *(str(path) for path in logs), "--out", str(tmp_path), "--parameters", "E,rho,delay,lag"]
    result = CliRunner().invoke(app, [*arguments, "--jobs", "2"])
    assert result.exit_code == 0, result.output
    (file,) = tmp_path.glob("identified-*.toml")
    tables = tomllib.loads(file.read_text())
    assert set(tables) == {"rod", "observer"}
    rig = tmp_path / "rig.toml"
    rig.write_text(f'include = ["{file.name}"]\n[rig]\nname = "arm"\n')
    config = load_config(rig)
    assert config.rod.youngs_modulus == pytest.approx(1.75e11, rel=0.03)
    assert config.rod.density == pytest.approx(18000.0, rel=0.03)
    assert config.observer.delay == pytest.approx(0.01, abs=0.002)
    numbers = json.loads((tmp_path / "identified.json").read_text())
    assert numbers["parameters"]["E"]["found"]
    assert numbers["correlation"]["E"]["E"] == 1.0
    assert "known weight on the tip: 40 g" in numbers["scale"]
    page = (tmp_path / "report.md").read_text()
    assert "| E | Pa | 1.9e+11 |" in page
    for name in ("residuals.png", "whiteness.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert not (tmp_path / ".unfinished").exists()
    again = CliRunner().invoke(app, [*arguments, "--jobs", "1"])
    assert again.exit_code == 0
    files = sorted(path.name for path in tmp_path.glob("identified-*.toml"))
    assert len(files) == 2, "an earlier result stays"
    first, second = (tomllib.loads((tmp_path / name).read_text()) for name in files)
    assert first == second


def test_without_a_weight_the_file_has_no_rod(logs: tuple[Path, Path], tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, ["identify", "fit", str(logs[0]), "--out", str(tmp_path), "--parameters", "E,rho,delay"]
    )
    assert result.exit_code == 0, result.output
    (file,) = tmp_path.glob("identified-*.toml")
    assert set(tomllib.loads(file.read_text())) == {"observer"}
    assert "rho/E" in file.read_text()
    assert "only ratios" in result.output.replace("\n", " ")


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (("--parameters", "mass"), "'mass': choose among E, rho"),
        (("--drive", "motor"), "--drive motor: choose among auto, measured, command"),
        (("--loss", "cubic"), "--loss cubic: choose among linear"),
        (("--weight", "other.mcap=0.05"), "other.mcap: is not one of the logs"),
    ],
)
def test_options_that_cannot_be_are_refused(logs: tuple[Path, Path], arguments: tuple[str, ...], match: str) -> None:
    result = CliRunner().invoke(app, ["identify", str(logs[0]), *arguments])
    assert isinstance(result.exception, UsageError)
    assert match in str(result.exception)


def test_a_plan_keeps_to_the_limits_and_asks_for_nothing_while_the_arm_moves() -> None:
    config = config_with()
    plan = propose(config, ("sway", "steps", "chirp"))
    for request in plan.requests:
        if request.reference is not None:
            points = np.array(request.reference.samples)
            assert np.all(np.diff(points[:, 0]) > 0.0)
    assert [one.action for one in plan.requests[:3]] == [
        ControlAction.REFERENCE, ControlAction.ARM, ControlAction.STOP
    ]  # fmt: skip
    times = [one.time for one in plan.requests]
    assert times == sorted(times)
    short = propose(config, ("steps",), 0.6)
    came_to = dry_run(rig_of_model(config), short)
    assert came_to.tension <= config.limits.tension_max
    assert came_to.displacement < 0.6 * config.limits.displacement_max


@pytest.mark.parametrize("mass", [0.045, 0.1])
def test_a_weight_in_the_dry_run_is_a_body_and_the_plan_for_it_stays_safe(mass: float) -> None:
    """The proposed weight, and the heaviest that the controller's defaults bear."""
    config = config_with()
    idealised = check_config({**BASE, "simulator": {"weight": {"force_only": True, "string": 0.3}}}, "test")
    assert rig_of_model(idealised, mass).simulator.weight == Weight(mass=mass)
    came_to = dry_run(rig_of_model(config, mass), propose(config, ("steps",), 0.6))
    assert came_to.tension < config.limits.tension_max
    assert came_to.displacement < config.limits.displacement_max
    assert came_to.speed < config.faults.tip_speed_max
    half = len(came_to.tip) // 20
    assert float(np.ptp(came_to.tip[-half:], axis=0).max()) < 0.2 * config.rod.length


def test_a_plan_that_the_rig_does_not_survive_is_refused() -> None:
    strict = check_config({**BASE, "limits": {**BASE["limits"], "limit_time": 0.01}}, "test")
    with pytest.raises(PlanError, match="ends in a fault"):
        dry_run(strict, propose(strict, ("chirp",)))
    plan = propose(strict, ("steps",), 0.6)
    early = replace(plan, requests=(Request(0.5, ControlAction.RESET), *plan.requests))
    with pytest.raises(PlanError, match="is refused: nothing to reset"):
        dry_run(config_with(), early)


def test_limits_that_leave_no_room_are_named() -> None:
    narrow = check_config({**BASE, "limits": {**BASE["limits"], "displacement_max": 0.001}}, "test")
    with pytest.raises(PlanError, match="leave the tip no room to move"):
        propose(narrow)
    with pytest.raises(PlanError, match="'jump': choose among sway, steps, chirp"):
        propose(config_with(), ("jump",))


def test_the_proposed_weight_bends_the_rod_by_a_quarter_of_its_length() -> None:
    """P L^3 / 3 EI, the textbook's cantilever; the paper's rod: 46 g."""
    assert proposed_weight(RigConfig()) == pytest.approx(0.045)


def test_goals_and_coverage_are_counted_against_the_truth() -> None:
    true = truth("tool")
    values = {**true, "C": 1.3 * true["C"], "tip_mass": true["tip_mass"] + 0.0008}
    errors = {name: 0.01 * value for name, value in true.items()}
    outcome = ProofOutcome(ProofTask("tool", 1, ""), values, errors, (), 30.0)
    assert met(outcome) == {"E": True, "rho": True, "Bbt": True, "C": False, "tip_mass": True, "delay": True}
    assert not met(replace(outcome, values={**true, "tip_mass": true["tip_mass"] - 0.001}))["tip_mass"]
    counted = coverage([outcome, replace(outcome, values={**values, "E": 1.015 * true["E"]})])
    assert counted["C"]["within_two"] == 0.0
    assert counted["E"] == pytest.approx({"fits": 2, "within_two": 1.0, "spread": 1.5 / 2**0.5, "bias": 0.75})
    assert "lag" not in counted
