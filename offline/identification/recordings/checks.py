"""Checks of recordings before anything is fitted to them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np

from tendond.offline.identification.configured import nominal
from tendond.offline.identification.recordings.recording import Drive, Recording
from tendond.offline.identification.simulation.motion import SimulationError
from tendond.offline.identification.simulation.simulate import Simulation
from tendond.offline.identification.simulation.simulated import Simulated

MIN_MOTION = 0.01
"""Minimum travel of the tip, as a fraction of the rod's length; and fifty times the poses' noise."""

MIN_SECONDS = 2.0
HIDDEN = 0.5
"""Fraction of the cycles without a pose above which a log is refused; a tenth of it is a warning."""

LIMITED = 0.7
"""Fraction of the armed cycles with the command at a limit above which there is a warning."""

STANDING = 0.3
"""Fraction of the pulling cycles with a tendon at the end of its range above which a log is refused."""

FOLLOWING = 0.01
"""Median difference of command and report over the moving cycles [m] above which a servo does not follow."""

PULLED = 0.002
"""Travel [m] above which a tendon counts as moving."""

REST_APART = 0.3
"""Distance of the measured rest from the model's, as a fraction of the rod's length, above which it is another rig: an
unknown 30 g on the tip lower the paper's tip by 0.13."""

ALONG = 0.3
"""Correlation of measured and modelled motion below which directions or tendons do not match."""

MISSED = 0.02
"""Fraction of missed deadlines above which there is a warning."""


@dataclass(frozen=True)
class Finding:
    """A problem in a recording.

    Attributes:
        level: error: the log cannot be used; warning: it can.
        name: name in a word or two. text: log, amount and remedy, in one line.
    """

    level: Literal["error", "warning"]
    name: str
    text: str


def check(
    recordings: Sequence[Recording], drive: Drive, simulate: Callable[[Recording], Simulated] | None = None,
    placed: bool = True,
) -> list[Finding]:  # fmt: skip
    """List all problems of recordings that are to be fitted together.

    Args:
        recordings: the recordings. drive: source of the tendons' ends.
        simulate: makes what computes a recording; none: its motion.
        placed: whether the base is where the configuration has it; not where its pose is to be found.
    """
    make = simulate or partial(Simulation, drive=drive)
    found = [finding for recording in recordings for finding in _alone(recording, drive, make, placed)]
    first = recordings[0]
    for other in recordings[1:]:
        found += _together(first, other)
    return found


def _alone(
    recording: Recording, drive: Drive, simulate: Callable[[Recording], Simulated], placed: bool
) -> list[Finding]:
    """List the problems of one recording."""
    path = recording.path
    found: list[Finding] = []

    def say(level: Literal["error", "warning"], name: str, text: str) -> None:
        found.append(Finding(level, name, f"{path}: {name}: {text}"))

    length = recording.config.rod.length
    if recording.ideal_drive:
        say("error", "ideal drive", (
            "a simulator's servos that impose the tension: it reports the tendons' paths, not their ends, and a fit "
            'would take that for a finding; set simulator.drive = "displacement" and record again'
        ))  # fmt: skip
        return found
    if recording.fault:
        say("warning", "fault", f"the controller faulted ({recording.fault}); what comes after is left out")
    if recording.duration < MIN_SECONDS:
        say("error", "too short", f"{recording.duration:.1f} s from rest to end; record {MIN_SECONDS:g} s or more")
    hidden = recording.hidden / recording.cycles
    if hidden > HIDDEN:
        say("error", "occlusions", f"no usable pose in {hidden:.0%} of the cycles; fix markers and cameras")
    elif hidden > 0.1 * HIDDEN:
        say("warning", "occlusions", f"no usable pose in {hidden:.0%} of the cycles; these are left out")
    if recording.missed > MISSED * recording.cycles:
        say("warning", "missed deadlines", f"{recording.missed} of {recording.cycles}; the machine was too busy")
    travel = float(np.linalg.norm(np.ptp(recording.position, axis=0)))
    required = max(MIN_MOTION * length, 50.0 * recording.noise)
    if travel < required:
        say(
            "error",
            "no motion",
            f"the tip moved by {travel * 1e3:.1f} mm; {required * 1e3:.1f} mm or more are needed",
        )
        return found
    found += _tendons(recording)
    if drive == "measured" and not recording.has_reports:
        say("error", "no reports", "the servos' displacement is not in the log: give --drive command")
        return found
    if placed:
        found += _like_the_model(simulate(recording))
    return found


def _tendons(recording: Recording) -> list[Finding]:
    """Check that tendons move, and follow their commands."""
    found = []
    armed, path = recording.armed, recording.path
    travel = np.ptp(recording.command[armed], axis=0) if np.any(armed) else np.zeros(recording.command.shape[1])
    pulled = armed & np.any(recording.command > 0.0, axis=1)
    pulling = [
        i for i in range(len(travel)) if travel[i] > PULLED and float(recording.command[armed, i].max()) > PULLED
    ]
    if not pulling:
        text = f"{path}: no tendon pulled: all displacements stay below {PULLED * 1e3:g} mm; arm, and track something"
        found.append(Finding("error", "no tendon pulled", text))
    elif len(pulling) == 1:
        text = (
            f"{path}: one tendon only: tendon {pulling[0]} alone pulls; the result holds for its side, and for the "
            "others as far as they are alike"
        )
        found.append(Finding("warning", "one tendon only", text))
    limits = recording.config.limits
    ends = (recording.command >= limits.displacement_max - 1e-9) | (recording.command <= limits.displacement_min + 1e-9)
    standing = float(np.mean(np.any(ends[pulled], axis=1))) if np.any(pulled) else 0.0
    if standing > STANDING:
        text = f"{path}: saturated: a tendon stands at the end of its range in {standing:.0%} of the pulling cycles"
        found.append(Finding("error", "saturated", f"{text}; reduce the range, or widen limits.displacement"))
    elif recording.limited > LIMITED:
        text = f"{path}: saturated: the command stood at a limit in {recording.limited:.0%} of the armed cycles"
        found.append(Finding("warning", "saturated", f"{text}; slower references say more"))
    if recording.has_reports and np.any(armed):
        at = np.clip(np.searchsorted(recording.times, recording.report_times), 0, len(armed) - 1)
        moving = armed[at] & (np.max(np.abs(np.gradient(recording.command, axis=0)), axis=1)[at] > 1e-5)
        if np.any(moving):
            behind = np.median(np.abs(recording.command[at][moving] - recording.reported[moving]), axis=0)
            worst = int(np.argmax(behind))
            if behind[worst] > FOLLOWING:
                text = (
                    f"{path}: saturated: servo of tendon {worst} is {behind[worst] * 1e3:.1f} mm off its command while "
                    "it moves; it is stuck, too weak, or not calibrated"
                )
                found.append(Finding("warning", "saturated", text))
    return found


def _like_the_model(simulation: Simulated) -> list[Finding]:
    """Check that it is this rig: its rest and its motion are similar to the model's."""
    recording = simulation.recording
    path, length = recording.path, recording.config.rod.length
    values = nominal(recording.config)
    try:
        motion = simulation.motion(values)
    except SimulationError as error:
        return [Finding("error", "no solution", f"{error}: the configuration's parameters are no start for a fit")]
    predicted = simulation.predicted_poses(motion, values["delay"])
    apart = float(np.linalg.norm(recording.position[:10].mean(axis=0) - predicted[:10].mean(axis=0)))
    if apart > REST_APART * length:
        text = (
            f"{path}: wrong rig: the tip rests {apart * 1e3:.0f} mm from where this configuration's rod would; fix "
            "rod.length, rod.gravity or the base's frame, or give the weight with --weight"
        )
        return [Finding("error", "wrong rig", text)]
    ours, theirs = predicted - predicted.mean(axis=0), recording.position - recording.position.mean(axis=0)
    size = float(np.linalg.norm(ours) * np.linalg.norm(theirs))
    along = float(np.sum(ours * theirs)) / size if size > 0.0 else 0.0
    if along < ALONG:
        text = (
            f"{path}: wrong rig: the tip does not go where the model goes (correlation {along:.2f}); fix the tendons' "
            "order, rod.tendon_positions or the base's axes"
        )
        return [Finding("error", "wrong rig", text)]
    return []


def _together(first: Recording, other: Recording) -> list[Finding]:
    """Check that two recordings are of one rig."""
    found = []
    if first.config.rig.name != other.config.rig.name:
        text = (
            f"{other.path}: wrong rig: is of rig '{other.config.rig.name}', {first.path.name} of "
            f"'{first.config.rig.name}'; fit each rig separately"
        )
        found.append(Finding("error", "wrong rig", text))
    for key in ("length", "radius", "tendon_positions", "gravity"):
        ours, theirs = getattr(first.config.rod, key), getattr(other.config.rod, key)
        if ours != theirs:
            text = f"{other.path}: wrong rig: rod.{key} = {theirs}, in {first.path.name} {ours}; use logs of one set-up"
            found.append(Finding("error", "wrong rig", text))
    for key in ("section", "tendon", "base"):
        if getattr(first.config.rod, key) != getattr(other.config.rod, key):
            text = f"{other.path}: wrong rig: rod.{key} is not that of {first.path.name}; use logs of one set-up"
            found.append(Finding("error", "wrong rig", text))
    ours, theirs = (nominal(one.config)["tip_mass"] for one in (first, other))
    if ours != theirs:
        text = (
            f"{other.path}: tip mass: rod.tip_mass = {theirs:g} kg, in {first.path.name} {ours:g} kg; one body is "
            "taken for both: give what is on the tip in one log only by --weight"
        )
        found.append(Finding("warning", "tip mass", text))
    return found


def errors(findings: Sequence[Finding]) -> list[Finding]:
    """Select the findings that rule out a fit."""
    return [finding for finding in findings if finding.level == "error"]
