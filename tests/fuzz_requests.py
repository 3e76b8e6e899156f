"""Fuzz every request of an operator, through planner and cycle: each is carried out or refused, and nothing breaks.

    python -m tests.fuzz_requests 100000 [SEED]       so many requests, in one process

Requests are drawn from the whole schema, with values at and beyond the edges. Each goes over the wire; a reference is
planned as the planner does it; the cycle takes it in whatever mode the requests before it have left. What must hold:
the cycle raises nothing, a reply says what was done or why not, the command is finite and within its limits.
"""

import json
import math
import random
import sys
import time
from collections import Counter
from typing import Any

from pydantic import ValidationError

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.daemon.control.tuning.keys import tunable_keys
from tendond.daemon.runtime.planner import make_plan
from tendond.drivers.simulator.lockstep import without_probe
from tendond.drivers.simulator.plant import Plant
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction, ControlRequest
from tendond.schemas.wire import decode, encode

KINDS = ("exponential", "step", "minimum_jerk", "samples", "point", "line", "circle", "helix", "figure_eight")
EDGES = (0.0, -0.0, 1e-12, -1e-12, 1e-3, 0.05, -0.1, 0.2, 0.34, 0.5, -0.5, 0.7, 1.0, 3.2, -6.3, 10.0, 1e3, 1e9, 5e-324)
TUNABLE = tuple(tunable_keys(RigConfig().with_own_rates()))
LIKELY = {Mode.IDLE: ControlAction.REFERENCE, Mode.TRACKING: ControlAction.STOP, Mode.FAULT: ControlAction.RESET}
"""Drawn more often in these modes, or most requests would be refused for their mode."""

BETWEEN = 8
"""Cycles at most between two requests."""


def value(draw: random.Random) -> float:
    """A number: of the arm's size, or from an edge."""
    return draw.choice(EDGES) if draw.random() < 0.4 else draw.uniform(-0.6, 0.6)


def vector(draw: random.Random, sizes: tuple[int, ...]) -> list[float]:
    """A vector of one of these sizes."""
    return [value(draw) for _ in range(draw.choice(sizes))]


def reference(draw: random.Random) -> dict[str, Any]:
    """Keys of [reference], some of which fit together."""
    kind = draw.choice(KINDS)
    keys: dict[str, Any] = {"kind": kind}
    choices: dict[str, Any] = {
        "branch": lambda: draw.choice(("above_135", "below_135", None)),
        "unreachable": lambda: draw.choice(("refuse", "track")),
        "path": lambda: draw.choice(("curve", "direct")),
        "rate": lambda: abs(value(draw)) * 50.0,
        "duration": lambda: abs(value(draw)) * 3.0,
        "aim": lambda: draw.choice(("position", "direction")),
        "start": lambda: vector(draw, (2, 3)),
        "end": lambda: vector(draw, (2, 3)),
        "center": lambda: vector(draw, (2, 3)),
        "radius": lambda: abs(value(draw)),
        "radius_end": lambda: abs(value(draw)),
        "period": lambda: abs(value(draw)) * 5.0,
        "laps": lambda: draw.choice((1, 1, 1, 2)),
        "moved_max": lambda: abs(value(draw)),
    }
    for name, make in choices.items():
        if draw.random() < 0.3:
            keys[name] = make()
    if kind in ("exponential", "step", "minimum_jerk", "point") or draw.random() < 0.05:
        name = draw.choice(("position", "across", "angle", "direction"))
        keys[name] = value(draw) if name in ("across", "angle") else vector(draw, (3,))
    if kind == "samples":
        width = draw.choice((2, 3))
        times = sorted({0.0, *(abs(value(draw)) for _ in range(draw.randint(1, 6)))})
        keys["samples"] = [[moment, *vector(draw, (width,))] for moment in times]
    return keys


def request(draw: random.Random, mode: Mode) -> ControlRequest | None:
    """A request that can be sent; none where what was drawn is refused before."""
    action = LIKELY[mode] if mode in LIKELY and draw.random() < 0.4 else draw.choice(list(ControlAction))
    keys: dict[str, Any] = {"action": action.value}
    if action is ControlAction.LAW:
        keys["law"] = draw.choice([*LAWS, "", "sensitivit", "\u2603", "x" * 64])
    if action is ControlAction.REFERENCE:
        keys["reference"] = reference(draw)
    if action is ControlAction.JOG:
        keys["jog"] = value(draw)
    if action is ControlAction.SET:
        names = (*TUNABLE, "limits.tension_min", "rod.length", "", "\u2603")
        keys["settings"] = {draw.choice(names): abs(value(draw)) for _ in range(draw.randint(1, 3))}
    try:
        return decode(ControlRequest, encode(ControlRequest.model_validate_json(json.dumps(keys))))
    except ValidationError:
        return None


def run(count: int, seed: int) -> dict[str, int]:
    """Put so many requests; what became of them.

    Raises:
        AssertionError: what must hold does not; the message has the request.
    """
    draw = random.Random(seed)
    config = without_probe(
        check_config({"reference": {"across": 0.2, "branch": "below_135"}, "commissioning": {"rest": False}}, "fuzz")
    )
    setup = CycleSetup.from_config(config)
    state = initial_state(setup)
    plant = Plant(config, rod_from_section(config.simulator.rod, config.loop.period))
    outcomes: Counter[str] = Counter()
    done = 0
    while done < count:
        asked = request(draw, state.mode)
        done += 1
        if asked is None:
            outcomes["refused before it is sent"] += 1
            continue
        try:
            if asked.reference is not None and state.mode is Mode.IDLE:
                outcomes[_plan(setup, state, asked)] += 1
            state, record = _cycle(setup, state, plant, asked)
            assert record.reply, "no reply"
            outcomes[f"{asked.action.value}: {'done' if record.accepted else 'refused'}"] += 1
            for _ in range(draw.randint(0, BETWEEN)):
                state, record = _cycle(setup, state, plant, None)
        except Exception as error:
            raise AssertionError(f"{type(error).__name__}: {error}\nrequest: {encode(asked).decode()}") from error
    return dict(sorted(outcomes.items()))


def _plan(setup: CycleSetup, state: CycleState, asked: ControlRequest) -> str:
    """Plan as the planner does; the cycle finds the plan, or finds the same error again."""
    assert asked.reference is not None
    plan = make_plan(setup, state.selection.law_name, asked.reference)
    assert not plan.error.startswith("planning failed"), plan.error
    if plan.reference is None:
        return "plan: refused"
    setup.plans.keep(plan.law, plan.section, plan.reference)
    return "plan: made"


def _cycle(
    setup: CycleSetup, state: CycleState, plant: Plant, asked: ControlRequest | None
) -> tuple[CycleState, CycleRecord]:
    """A cycle, in closed loop with the plant, and what must hold after it."""
    pose, tendon_state, _ = plant.observe(0)
    inputs = CycleInputs(
        pose=pose,
        tendon_state=tendon_state,
        request=None if asked is None else asked.action,
        law=None if asked is None else asked.law,
        reference=None if asked is None else asked.reference,
        jog=None if asked is None else asked.jog,
        settings={} if asked is None or asked.settings is None else asked.settings,
    )
    before = state.tension_command
    state, command, record = step(setup, state, inputs)
    plant.step(command)
    limits = setup.config.limits
    rate = max(limits.tension_rate, limits.release_rate) * setup.config.loop.period
    for tension, last, displacement in zip(command.tension, before.tolist(), command.displacement, strict=True):
        assert math.isfinite(tension), command
        assert math.isfinite(displacement), command
        assert 0.0 <= tension <= limits.tension_max, command
        assert abs(tension - last) <= rate + 1e-9, command
    return state, record


def main() -> None:
    """See the module."""
    if len(sys.argv) not in (2, 3) or not all(one.isdigit() for one in sys.argv[1:]):
        raise SystemExit(__doc__)
    seed = int(sys.argv[2]) if len(sys.argv) == 3 else int(time.time())
    started = time.monotonic()
    outcomes = run(int(sys.argv[1]), seed)
    print(json.dumps({"seed": seed, "seconds": round(time.monotonic() - started, 1), **outcomes}, indent=1))


if __name__ == "__main__":
    main()
