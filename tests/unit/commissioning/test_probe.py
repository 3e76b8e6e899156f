"""The probe of the tendons: a right rig passes in about two seconds, a wrong one is named before it is pulled at."""

from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.control.commissioning.verdict import Bounds, Motion, judge
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState
from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.offline.replay.offline import record_lockstep
from tendond.offline.replay.rerun import rerun
from tendond.schemas.config.presets import NASTY, RIG, WIRED
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

ARM = 40
BOUNDS = Bounds(angle=0.6, gain_min=0.62, gain_max=1.5, slack=0.001)
MOTIONS = [(0.0128, 0.0, 0.0006), (0.0, 0.0128, 0.0), (-0.0128, 0.0, -0.001), (0.0, -0.0128, 0.0)]


def tendons(*order: int, signs: tuple[float, float] = (1.0, 1.0)) -> str:
    """The plant's tendons in another order, or with x or y of all of them mirrored."""
    places = [(0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02)]
    return f"tendon_positions = {[[signs[0] * places[i][0], signs[1] * places[i][1]] for i in order]}\n"


def run(text: str, cycles: int = 1500, request: ControlAction = ControlAction.ARM) -> list[Watched]:
    """Armed at `ARM`, until it tracks, is idle again, or is in fault and has let go."""
    trace = []
    for watched in watched_loop(parse_config(text, "test"), cycles, {ARM: request}, probe=True):
        trace.append(watched)
        mode = watched.record.mode
        over = mode is Mode.TRACKING or (mode is Mode.IDLE and watched.record.tick > ARM)
        if over or (mode is Mode.FAULT and not watched.record.command.armed):
            break
    return trace


def within_the_probe(config: RigConfig, trace: list[Watched], moved_max: float = 0.06) -> bool:
    """Check that no tendon got more than a tenth of tension_max, and the tip moved no more than a probe may."""
    probed = [one for one in trace if one.record.mode is not Mode.TRACKING]
    pulled = max(max(one.record.command.tension) for one in probed)
    start = np.array(trace[ARM].truth.position)
    moved = max(float(np.linalg.norm(np.array(one.truth.position) - start)) for one in probed)
    return pulled <= 0.1 * config.limits.tension_max and moved < moved_max * config.rod.length


@pytest.mark.parametrize(
    ("text", "longest"),
    [
        ("", 3.2),
        ("[simulator.rod]\nyoungs_modulus = 152e9\n", 7.0),
        ("[simulator.rod]\nyoungs_modulus = 228e9\n", 6.0),
        ("[simulator.weight]\nmass = 0.05\n", 14.0),
        ("[simulator.weight]\nmass = 0.1\n[simulator.rod]\nyoungs_modulus = 152e9\n", 16.0),
        (RIG, 5.0),
        (WIRED, 5.0),
        (NASTY.partition("[[simulator.impacts]]")[0], 14.0),
        ("[rod]\nlength = 0.3\n[simulator.rod]\nlength = 0.3\n[reference]\nacross = 0.15\n", 3.2),
        ("[rod]\ngravity = [0.0, 0.0, -9.81]\n[simulator.rod]\ngravity = [0.0, 0.0, -9.81]\n", 3.2),
        ("[loop]\nperiod = 0.004\n[simulator]\nperiod = 0.004\n", 3.2),
    ],
    ids=["default", "E-20", "E+20", "50 g", "100 g E-20", "rig", "wired", "nasty", "short", "upright", "250 Hz"],
)
def test_a_right_rig_passes_with_little_tension_and_soon_tracks(text: str, longest: float) -> None:
    trace = run(text)
    config = parse_config(text, "test")
    assert trace[ARM].record.reply == "armed: probing the tendons"
    assert trace[-1].record.mode is Mode.TRACKING, trace[-1].record.reason
    assert within_the_probe(config, trace[:-1])
    assert (trace[-1].record.tick - ARM) * config.loop.period < longest


@pytest.mark.parametrize("chain", ["", RIG.replace("[simulator.rod]\n", "[simulator.rod]\n@")], ids=["ideal", "servos"])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (tendons(2, 1, 0, 3), "are tendons 0 and 2 swapped?"),
        (tendons(1, 0, 2, 3), "are tendons 0 and 1 swapped?"),
        (tendons(0, 3, 2, 1), "are tendons 1 and 3 swapped?; or is the camera's frame mirrored in y?"),
        (tendons(1, 2, 3, 0), "are the tendons connected in another order?; or is the camera's frame rotated by 90"),
        (tendons(0, 1, 2, 3, signs=(1.0, -1.0)), "are tendons 1 and 3 swapped?"),
        (tendons(2, 3, 0, 1), "are tendons 0 and 2 swapped?; are tendons 1 and 3 swapped?"),
    ],
)  # fmt: skip
def test_swapped_tendons_are_named_before_anything_pulls_hard(chain: str, change: str, words: str) -> None:
    text = chain.replace("@", change) if chain else f"[simulator.rod]\n{change}"
    trace = run(text)
    assert trace[-1].record.mode is Mode.FAULT
    assert trace[-1].record.reason.startswith("wiring: ")
    if not chain:  # servos that pull show the sag of the arm as well, and not each mistake as clearly
        assert words in trace[-1].record.reason
    else:
        assert max(max(one.truth.tension) for one in trace) < 0.2 * parse_config(text, "test").limits.tension_max
    assert within_the_probe(parse_config(text, "test"), trace, 0.11)
    assert trace[-1].record.command.tension == (0.0,) * 4


def motions(*measured: tuple[float, float, float] | None) -> list[Motion]:
    return [Motion(expected if one is None else one, expected) for one, expected in zip(measured, MOTIONS, strict=True)]


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (motions(None, None, None, None), ""),
        (motions(None, (0.0, 0.0002, 0.0), None, None), "tendon 1 does not move the tip (0.2 of 12.8 mm): wound the"),
        (motions((0.0256, 0.0, 0.001), None, None, None), "tendon 0 moves the tip 2.0 times as far as it should: is"),
        (motions(None, None, (-0.0064, 0.0, -0.0005), None), "tendon 2 moves the tip 0.5 times as far"),
        (motions(*[(0.0, 0.0, 0.0)] * 4), "is the power of the servos on, and the arm free?"),
        (motions((0.009, 0.009, 0.0), None, None, None), "tendon 0 moves the tip 45 degrees off its direction"),
        (
            [*motions(None, None, None, None)[:3], Motion((0.0, 0.0, 0.0), MOTIONS[3], 0.003, 0.0)],
            "does its servo turn?",
        ),
    ],
)  # fmt: skip
def test_the_verdict_names_the_tendon_and_what_is_wrong_with_it(found: list[Motion], words: str) -> None:
    verdict = judge(found, BOUNDS)
    assert words in verdict
    assert bool(verdict) == bool(words)


def test_a_second_arming_goes_straight_to_the_pretension_and_one_after_a_fault_probes_again() -> None:
    texts = {ARM: ControlAction.ARM, 400: ControlAction.STOP, 700: ControlAction.ARM}
    config = parse_config("[simulator.mocap]\nnoise = 1e-5\n", "test")
    replies = {one.record.tick: one.record for one in watched_loop(config, 800, texts, probe=True)}
    assert replies[ARM].mode is Mode.PROBE
    assert (replies[700].reply, replies[700].mode) == ("armed", Mode.PRETENSION)


def test_the_probe_alone_lets_go_and_tells_what_it_has_found() -> None:
    trace = run("", request=ControlAction.PROBE)
    assert trace[ARM].record.reply == "probing the tendons"
    assert trace[-1].record.mode is Mode.IDLE
    assert trace[-1].record.reason.startswith(
        "released: probed: every tendon moves the tip as the model says (times 1.0"
    )
    assert Mode.TRACKING not in {one.record.mode for one in trace}


def test_a_state_within_the_probe_comes_back_from_its_text() -> None:
    config = parse_config(RIG, "test")
    setup = CycleSetup.from_config(config)
    states: list[CycleState] = []
    for watched in watched_loop(config, 180, {ARM: ControlAction.ARM}, see_state=states.append, probe=True):
        assert watched.record.mode is not Mode.FAULT
    probe = states[-1].probe
    assert probe is not None
    assert len(probe.motions) >= 1
    assert encode_state(decode_state(CycleState, encode_state(states[-1]), setup)) == encode_state(states[-1])


def test_a_probe_replays_to_the_last_bit(tmp_path: Path) -> None:
    setup = CycleSetup.from_config(parse_config(RIG, "test"))
    records = record_lockstep(setup, 400, {ARM: ControlAction.ARM}, tmp_path / "run.mcap")
    assert {record.mode for record in records} >= {Mode.PROBE, Mode.TRACKING}
    outcome = rerun(tmp_path / "run.mcap")
    assert outcome.compared == 400
    assert outcome.first is None


def test_the_tendon_that_was_probed_last_ends_slack_and_does_not_hold_the_command_at_a_limit() -> None:
    """A thousandth of a newton left in it would keep its displacement at the rate's limit until that is a fault."""
    tracked = [
        watched.record
        for watched in watched_loop(parse_config(WIRED, "test"), 600, {ARM: ControlAction.ARM}, probe=True)
        if watched.record.mode in (Mode.TRACKING, Mode.FAULT)
    ]
    assert len(tracked) > 150
    assert all(record.mode is Mode.TRACKING for record in tracked)
    assert all(record.tension_estimate[3] == 0.0 for record in tracked[50:])
