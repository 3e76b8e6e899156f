"""Whatever comes in: the command is finite and within its limits, a fault is latched, the record can be written.

Sequences are drawn by hypothesis; 10^5 cycles and more altogether, counted, on a rod that is quick to solve.
"""

import itertools
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.model.numerics.rotation import quaternion
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction

CYCLES = 100_000
"""Smallest number over all examples."""

COARSE = "[rod]\nspace = 'euler'\nnodes = 12\n[simulator.rod]\nspace = 'euler'\nnodes = 12\n"
CONFIGS = [
    parse_config(COARSE + extra, "test")
    for extra in (
        "",
        "[control]\nfeedback = 'direct'\nantagonist = 2\n[limits]\ntension_max = 12.0\ntension_rate = 300.0\n"
        "[reference]\nacross = 0.1\n[commissioning]\nprobe = false\nrest = false\n",
        "[control]\nlaw = 'sliding_mode'\n[limits]\ndisplacement_max = 0.02\ndisplacement_rate = 0.2\nslack = 0.002\n"
        "[observer]\nlag = 0.03\ndelay = 0.025\n[commissioning]\nprobe = false\n",
    )
]
STARTS = [(setup, initial_state(setup)) for setup in map(CycleSetup.from_config, CONFIGS)]

near = st.floats(-0.5, 0.5)
wild = st.floats(allow_nan=False, allow_infinity=False)
positions = st.tuples(near, near, near) | st.tuples(wild, wild, wild) | st.none()
requests = st.sampled_from([None] * 30 + list(ControlAction) + [ControlAction.ARM] * 4)
references = st.sampled_from(
    [None, ReferenceSection(across=0.2), ReferenceSection(across=9.0), ReferenceSection(angle=1.0, kind="step")]
)
events = st.tuples(
    st.integers(1, 60),  # cycles that it lasts
    st.sampled_from(["model", "model", "model", "frozen", "none", "drawn", "old", "hidden"]),
    positions,
    requests,
    references,
    st.sampled_from([None, "backstepping", "sliding_mode", "pid"]),
    st.sampled_from(["fine", "fine", "none", "servo 2: overheating (bit 2)", "three"]),
    st.sampled_from([0, 0, 0, 0, 0, 1, 30]),
    st.sampled_from([{}, {}, {"malformed": 3}]),
)


def poses(state: CycleState, setup: CycleSetup, source: str, drawn: Any) -> TipPose | None:
    """The pose that an event brings: where the model is, or anything else."""
    seq = 0 if state.pose is None else state.pose.seq + 1
    position, orientation = tuple(state.tip.position.tolist()), quaternion(state.tip.rotation)
    if source == "none" or (source == "drawn" and drawn is None):
        return None
    if source == "drawn":
        position = drawn
    elif source == "frozen" and state.pose is not None:
        position = state.pose.position
    return TipPose(
        seq=0 if source == "old" else seq,
        stamp_ns=0,
        position=position,
        orientation=orientation,
        valid=source != "hidden",
    )


def tendons(tick: int, kind: str) -> TendonState | None:
    if kind == "none":
        return None
    zeros = (0.0,) * (3 if kind == "three" else 4)
    return TendonState(
        seq=tick, stamp_ns=0, displacement=zeros, tension=zeros, fault="" if kind in ("fine", "three") else kind
    )


def check(config: RigConfig, before: CycleState, after: CycleState, inputs: CycleInputs, record: CycleRecord) -> None:
    """Assert the invariants of every cycle."""
    limits, period = config.with_own_rates().limits, config.loop.period
    command = record.command
    tension, displacement = np.array(command.tension), np.array(command.displacement)
    assert np.isfinite(tension).all()
    assert np.isfinite(displacement).all()
    assert ((tension >= 0.0) & (tension <= limits.tension_max)).all()
    assert (
        np.abs(tension - before.tension_command) <= max(limits.tension_rate, limits.release_rate) * period + 1e-9
    ).all()
    assert ((displacement >= limits.displacement_min) & (displacement <= limits.displacement_max)).all()
    if not command.armed:
        assert not displacement.any()
    elif record.mode is not Mode.PROBE or before.mode is Mode.PROBE:  # a probe begins where the servos stand
        assert (np.abs(displacement - before.displacement_command) <= limits.displacement_rate * period + 1e-9).all()
    reset = inputs.request is ControlAction.RESET
    if before.mode is Mode.FAULT and not (reset and record.accepted):
        assert record.mode is Mode.FAULT
    if record.mode in (Mode.IDLE, Mode.FAULT, Mode.RELEASING) and before.mode is record.mode:
        assert (tension <= before.tension_command + 1e-12).all()  # nothing pulls who is not asked to
    if record.mode is Mode.IDLE:
        assert not command.armed
    if after.selection is not before.selection:
        assert before.mode in (Mode.IDLE, Mode.STARTING)


seen = {"cycles": 0, "records": 0}
modes: set[Mode] = set()
reasons: set[str] = set()


def run(which: int, script: list[Any]) -> None:
    (setup, state), config = STARTS[which], CONFIGS[which]
    for length, source, drawn, request, reference, law, driver, missed, unreadable in script:
        for k in range(length):
            first = k == 0
            inputs = CycleInputs(
                pose=poses(state, setup, source, drawn),
                tendon_state=tendons(state.tick, driver),
                request=request if first else None,
                law=law if first and request is ControlAction.LAW else None,
                reference=reference if first and request is ControlAction.REFERENCE else None,
                missed_ticks=missed if first else 0,
                unreadable=unreadable,
            )
            before = state
            state, _, record = step(setup, state, inputs)
            check(config, before, state, inputs, record)
            modes.add(record.mode)
            if record.mode is Mode.FAULT:
                reasons.add(record.reason.split(":")[0])
            seen["cycles"] += 1
    line = record.model_dump_json()
    assert CycleRecord.model_validate_json(line).model_dump_json() == line
    seen["records"] += 1


@settings(
    max_examples=250, deadline=None, phases=(Phase.generate, Phase.shrink), suppress_health_check=list(HealthCheck)
)
@given(st.integers(0, len(CONFIGS) - 1), st.lists(events, min_size=1, max_size=40))
def test_whatever_comes_in_the_command_is_finite_and_within_its_limits(which: int, script: list[Any]) -> None:
    run(which, script)


def test_arm_and_anything_after_it_and_a_hundred_thousand_cycles_in_all() -> None:
    """Random scripts from a generator make up the number, armed as soon as may be: most of hypothesis' are short."""
    rng = np.random.default_rng(1)
    for k in itertools.count():
        if seen["cycles"] >= CYCLES:
            break
        script: list[Any] = [(2, "model", None, None, None, None, "fine", 0, {})]
        for _ in range(12):
            source = str(rng.choice(["model"] * 12 + ["frozen", "none", "drawn", "old", "hidden"]))
            drawn = tuple(rng.normal(0.0, 0.2, 3).tolist()) if rng.random() < 0.5 else (0.0, 0.0, -0.7)
            request = rng.choice(np.array([None, None, None, *ControlAction, ControlAction.ARM, ControlAction.RESET]))
            driver = str(rng.choice(["fine"] * 8 + ["none", "servo 2: overheating (bit 2)"]))
            missed = int(rng.choice([0] * 10 + [1, 30]))
            script.append((
                int(rng.integers(1, 60)), source, drawn, None if request is None else ControlAction(request),
                ReferenceSection(across=float(rng.uniform(0.05, 0.4))), "sliding_mode", driver, missed, {},
            ))  # fmt: skip
        run(k % len(CONFIGS), script)
    assert seen["cycles"] >= CYCLES
    assert modes == set(Mode) - {Mode.STARTING}
    assert {"pose stale", "overrun", "tendons", "teleport", "bad poses"} <= reasons, reasons
