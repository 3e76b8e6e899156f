"""The learned correction in the loop: on a bent wire that the model takes for straight, replayed, bounded, refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.errors import ParameterError
from tendond.model.rods.selection import model_rod
from tendond.offline.correction.learned import as_section, train
from tendond.schemas.config.observer import ResidualSection
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

BENT = {
    "reference": {"across": 0.2, "branch": "below_135"},
    "control": {"solver": "general"},
    "simulator": {
        "rod": {"section": [{
            "length": 0.5, "radius": 1e-3, "youngs_modulus": 207e9, "density": 8000.0,
            "bending_damping": [0.008] * 3, "drag": [0.1] * 3, "precurvature": [0.0, 0.03, 0.0],
        }]},
    },
}  # fmt: skip


def learned() -> ResidualSection:
    """The correction from rests of the bent wire and of the straight model under the same tensions."""
    config = check_config(BENT, "bent")
    plant = model_rod(config.model_copy(update={"rod": config.simulator.rod}))
    model = model_rod(config)
    pulls, errors, before, ahead = [], [], None, None
    for pull in np.tile(np.concatenate((np.linspace(0.0, 20.0, 25), np.linspace(20.0, 0.0, 25))), 5):
        tensions = [float(pull), 0.0, 0.0, 0.0]
        before, ahead = plant.solve_static(tensions, start=before), model.solve_static(tensions, start=ahead)
        pulls.append(model.displacements(ahead))
        errors.append(plant.tip(before).position - model.tip(ahead).position)
    block = np.arange(len(pulls)) // 10
    return as_section(train(np.array(pulls), np.array(errors), block, np.ones(len(pulls), dtype=np.bool_)))


def with_residual(section: ResidualSection | None) -> RigConfig:
    observer = {} if section is None else {"residual": section.model_dump()}
    return check_config({**BENT, "observer": observer}, "corrected")


def run(config: RigConfig, states: list[CycleState] | None = None) -> list[CycleRecord]:
    see = None if states is None else states.append
    return [one.record for one in watched_loop(config, 400, {5: ControlAction.ARM}, see_state=see)]


def test_what_is_learned_needs_no_force_to_explain_it() -> None:
    section = learned()
    states: list[CycleState] = []
    plain, corrected = run(with_residual(None)), run(with_residual(section), states)
    off = []
    for records in (plain, corrected):
        assert records[-1].mode is Mode.TRACKING
        off.append(np.linalg.norm(np.array(records[-1].measured) - np.array(records[-1].reference.position)))
    assert off[1] < 0.1e-3 < 0.5e-3 < off[0]  # the straight model cannot reach the bent wire's surface
    forces = [np.linalg.norm(records[-1].observer.force) for records in (plain, corrected)]
    assert forces[1] < 0.1 * forces[0]
    shifts = [one.observer.residual for one in corrected]
    assert all(shift is not None and np.linalg.norm(shift) <= section.bound * (1.0 + 1e-12) for shift in shifts)
    setup = CycleSetup.from_config(with_residual(section))
    before = states[200].correction
    again = decode_state(CycleState, encode_state(states[200]), setup).correction
    assert before is not None
    assert again is not None
    assert again.shift.tolist() == before.shift.tolist()


def test_beside_its_data_the_correction_is_off_and_left_out_of_no_record() -> None:
    section = learned()
    elsewhere = section.model_copy(update={"low": (0.5,) * 4, "high": (0.6,) * 4})
    plain, off = run(with_residual(None)), run(with_residual(elsewhere))
    assert [one.command for one in plain] == [one.command for one in off]
    assert {one.observer.residual for one in off} == {(0.0, 0.0, 0.0)}
    assert "residual" not in json.loads(plain[0].model_dump_json())["observer"]


def test_a_correction_of_another_robot_is_refused(tmp_path: Path) -> None:
    section = learned()
    three = {**section.model_dump(), "low": section.low[:3], "high": section.high[:3]}
    with pytest.raises(ConfigError, match=r"residual\.low has 3 numbers, but the rod 4 tendons"):
        check_config({**BENT, "observer": {"residual": three}}, "wrong")
    short = {**section.model_dump(), "coefficients": section.coefficients[:-1]}
    with pytest.raises(ConfigError, match="rows for"):
        check_config({**BENT, "observer": {"residual": short}}, "wrong")
    renamed = section.model_copy(update={"features": ("one", *section.features[1:])})
    with pytest.raises(ParameterError, match="features are not those"):
        CycleSetup.from_config(with_residual(renamed))
