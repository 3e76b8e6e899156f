"""No cycle takes long: whatever law, kind of reference and number of tendons an operator chooses, and when."""

import math
import statistics
import time
from typing import Any

import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import changed
from tendond.daemon.runtime.planner import make_plan
from tendond.daemon.runtime.warm_up import warm_up
from tendond.drivers.simulator.lockstep import without_probe
from tendond.drivers.simulator.plant import Plant
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.reference import SPACE_KINDS, ReferenceSection
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

TIMES_MEDIAN = 60.0
"""Longest cycle in median cycles, both in CPU time: planning in a cycle would take thousands, compiling hundreds.

Measured: at most 10 while tracking and 30 for a request, beside other processes too, which an absolute time would not
bear.
"""

IN_THE_PLANE: dict[str, dict[str, Any]] = {
    "exponential": {"across": 0.2, "branch": "below_135"},
    "step": {"across": 0.2, "branch": "below_135"},
    "minimum_jerk": {"across": 0.2, "branch": "below_135"},
    "samples": {"samples": ((0.0, -0.028, 0.499), (1.0, 0.0, 0.5)), "unreachable": "track"},
}
IN_SPACE: dict[str, dict[str, Any]] = {
    "point": {"position": (0.1, 0.1, 0.46)},
    "line": {"laps": 1},
    "circle": {"radius": 0.1, "laps": 20},
    "helix": {"radius": 0.15, "laps": 2},
    "figure_eight": {"radius": 0.1, "laps": 2},
}
OF_SECTIONS = {"pose", "path"}
"""Kinds that take the general rod, with more to move than the tip of one section; `tests/unit/pose` tries them."""

SURROUNDED = 3
"""Tendons from which on the law `sensitivity` bends the rod to every side."""


def ring(count: int) -> list[list[float]]:
    angles = [2.0 * math.pi * k / count for k in range(count)]
    return [[round(0.02 * math.cos(angle), 6), round(0.02 * math.sin(angle), 6)] for angle in angles]


def test_every_kind_of_reference_is_tried_here() -> None:
    kinds = ReferenceSection.model_json_schema()["properties"]["kind"]["enum"]
    assert set(kinds) == {*IN_THE_PLANE, *IN_SPACE, *OF_SECTIONS}
    assert {*IN_SPACE, *OF_SECTIONS} == set(SPACE_KINDS)


@pytest.mark.parametrize("count", [1, 3, 4])
def test_no_cycle_takes_long(count: int) -> None:
    tendons = {"tendon_positions": ring(count)}
    start = {"across": 0.2, "branch": "below_135"}
    config = without_probe(
        check_config(
            {"rod": tendons, "simulator": {"rod": tendons}, "reference": start, "commissioning": {"rest": False}},
            "test",
        )
    )
    setup = CycleSetup.from_config(config)
    ready = warm_up(setup)
    plant = Plant(config, rod_from_section(config.simulator.rod, config.loop.period))
    plain: list[float] = []
    longest: dict[bool, tuple[float, str]] = {False: (0.0, ""), True: (0.0, "")}
    tried = 0
    for law in [name for name in LAWS if name != "mpc"]:  # which needs the general rod
        for kind, keys in {**IN_THE_PLANE, **IN_SPACE}.items():
            section = ReferenceSection.model_validate({"kind": kind, **keys})
            plan = make_plan(setup, law, section)
            in_space = law == "sensitivity"
            if plan.reference is None:
                assert (kind in IN_SPACE and not in_space) or (in_space and count < SURROUNDED), (law, kind, plan.error)
                continue
            tried += 1
            state = ready
            for tick in range(45):
                pose, tendon_state, _ = plant.observe(0)
                assert pose is not None
                inputs: dict[str, Any] = {
                    "pose": pose.model_copy(update={"seq": tick}),
                    "tendon_state": tendon_state.model_copy(update={"seq": tick}),
                }
                match tick:
                    case 3:
                        inputs.update(request=ControlAction.LAW, law=law)
                    case 4:
                        setup.plans.keep(law, section, plan.reference)
                        inputs.update(request=ControlAction.REFERENCE, reference=section)
                    case 5:
                        inputs.update(request=ControlAction.ARM)
                    case 35:
                        inputs.update(request=ControlAction.STOP)
                    case 40:
                        runs = changed(state.bad_cycles, solver_failures=1)
                        slack = 0.0 * state.tension_estimate
                        state = changed(
                            state,
                            mode=Mode.FAULT,
                            bad_cycles=runs,
                            tension_estimate=slack,
                            tension_command=slack,
                            release_pending=False,
                        )
                        inputs.update(request=ControlAction.RESET)
                asked = CycleInputs(**inputs)
                began = time.thread_time()
                state, _, record = step(setup, state, asked)
                took = time.thread_time() - began
                if asked.request is None:
                    plain.append(took)
                else:
                    assert record.accepted, record.reply
                requested = asked.request is not None
                if took > longest[requested][0]:
                    longest[requested] = (took, f"{law}, {kind}, cycle {tick}, {asked.request}, {record.mode}")
    assert tried == (2 * len(IN_THE_PLANE) + (len(IN_THE_PLANE) + len(IN_SPACE)) * (count >= SURROUNDED))
    assert max(longest.values())[0] < TIMES_MEDIAN * statistics.median(plain), longest
