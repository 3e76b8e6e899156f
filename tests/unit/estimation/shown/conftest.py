"""A short run in lockstep with the filter, pushed out of its plane."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.offline.replay.offline import record_lockstep
from tendond.schemas.config.rig import check_config
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

PUSH = (0.0, 0.3, 0.0)
"""Force on the tip in the second half [N]."""

CYCLES = 120


@dataclass(frozen=True)
class Filtered:
    """The log, its records, and the setup of its cycles."""

    path: Path
    records: list[CycleRecord]
    setup: CycleSetup


@pytest.fixture(scope="package")
def filtered(tmp_path_factory: pytest.TempPathFactory) -> Filtered:
    tables = {
        "control": {"solver": "general"},
        "observer": {"kind": "kalman"},
        "simulator": {"impacts": [{"time": 0.6, "duration": 1.0, "force": PUSH}]},
        "log": {"shape_period": 5},
        "commissioning": {"probe": False},
    }
    setup = CycleSetup.from_config(check_config(tables, "test"))
    path = tmp_path_factory.mktemp("filter") / "run.mcap"
    return Filtered(path, record_lockstep(setup, CYCLES, {5: ControlAction.ARM}, path), setup)
