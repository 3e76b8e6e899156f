"""`tendond rig teach record`, `play`, and `tendond log teach`: a path that somebody shows, written and played."""

import time
from collections.abc import Callable
from pathlib import Path
from shlex import quote

from pydantic import ValidationError

from tendond.bus.client import BusError, open_client
from tendond.bus.subscription import Subscription
from tendond.cli.common import load_config, read_rows, say
from tendond.cli.rig.operator import option_of, set_reference
from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.progress import working
from tendond.offline.teaching.path import Columns, shown, smoothed, write_path
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import TipPose

CONNECT_SECONDS = 3.0
SILENCE_SECONDS = 3.0
"""Time without a pose after which recording ends with an error: no camera, or another rig."""

POLL_SECONDS, KEPT = 0.02, 256
"""Time between two looks for poses, and poses kept meanwhile: at 1000 a second ten times as many as arrive."""


def record(
    config_file: Path | None,
    out: Path,
    duration: float | None,
    columns: Columns | None,
    smoothing: float,
    stopped: Callable[[], bool],
) -> None:
    """Record poses from the bus and write the path; see `tendond rig teach record --help`.

    Raises:
        TendondError: no controller or no poses, nothing moved, or the file cannot be written.
    """
    config = load_config(config_file)
    poses: list[tuple[float, TipPose]] = []
    with open_client(config.bus.endpoint, CONNECT_SECONDS) as session:
        subscription = Subscription(session, key(config.rig.name, TIP_POSE), TipPose, KEPT)
        began = heard = time.monotonic()
        say("recording: move the arm; end with Ctrl-C" if duration is None else f"recording for {duration:g} s")
        while not stopped() and (duration is None or time.monotonic() - began < duration):
            for pose in subscription:
                heard = time.monotonic()
                # The publisher's own clock has the spacing of the poses; this one only their arrival.
                poses.append((pose.stamp_ns * 1e-9, pose))
            if time.monotonic() - heard > SILENCE_SECONDS:
                raise BusError(
                    f"no pose of rig '{config.rig.name}' for {SILENCE_SECONDS:g} s: start its camera or simulator"
                )
            time.sleep(POLL_SECONDS)
    write(config, poses, out, columns, smoothing, option_of(config_file))


def teach_from_log(
    file: Path, out: Path | None, columns: Columns | None, smoothing: float, span: tuple[float, float]
) -> None:
    """Write the measured path of a log; see `tendond log teach --help`.

    Args:
        file: the log. out: CSV file; default: beside the log.
        columns, smoothing: see `write`.
        span: first and last time to take, of the cycles' [s].

    Raises:
        LogError: the log cannot be used. UsageError: nothing moved. DaemonError: the file cannot be written.
    """
    from tendond.offline.logs.log import load

    log = load(file)
    poses = [
        (one.inputs.pose.stamp_ns * 1e-9, one.inputs.pose)
        for one in log.records
        if one.inputs.pose is not None and span[0] <= one.time <= span[1]
    ]
    if not poses:
        end = log.records[-1].time
        raise UsageError(
            f"{file}: has no pose from {span[0]:g} to {span[1]:g} s: it lasts {end:.1f} s; see --from, --to"
        )
    # Which file the rig's configuration is in is not in the log.
    rig = "" if log.config.bus == RigConfig().bus and log.config.rig == RigConfig().rig else " --config FILE"
    write(log.config, poses, out or file.with_name(f"{file.stem}-path.csv"), columns, smoothing, rig)


def write(
    config: RigConfig,
    poses: list[tuple[float, TipPose]],
    out: Path,
    columns: Columns | None,
    smoothing: float,
    rig: str = "",
) -> None:
    """Smooth poses, write them, and say how to play them.

    Args:
        config: the rig's. poses: with their times [s]. out: CSV file.
        columns: to write; default: what the rig's law and robot follow.
        smoothing: standard deviation of the filter [s].
        rig: option that names the rig, for the hint at the end.

    Raises:
        UsageError: nothing moved. DaemonError: the file cannot be written.
    """
    chosen = columns or columns_for(config)
    rows = smoothed(shown(poses), smoothing)
    count = write_path(rows, chosen, out)
    print(f"{out}: {count} samples, {rows[-1, 0]:.2f} s, {chosen}")
    with working("trying to play it"):
        settings, refusal = needed_to_play(config, out)
    command = f"tendond rig teach play {quote(str(out))}{settings}{rig}"
    if refusal and settings:
        say(f"of an arm in motion, the tip is beside where it can rest: {refusal}")
    if refusal and not settings:
        say(f"rig '{config.rig.name}' would refuse to play it as it is: {refusal}")
    print(f"play it on rig '{config.rig.name}' while it is idle with: {command}")


def needed_to_play(config: RigConfig, file: Path) -> tuple[str, str]:
    """Try a path as a rig's reference; return what `teach play` needs beside it, and why the plain path is refused.

    Args:
        config: the rig's. file: of the path.

    Returns:
        Settings with a space before each, empty if none are needed or none help; and the refusal, empty without one.
    """
    from tendond.daemon.control.selection import Selection
    from tendond.daemon.control.setup import with_its_rod
    from tendond.model import ModelError
    from tendond.model.numerics.announce import announce_compilation
    from tendond.model.rods.selection import model_rod

    announce_compilation(say)
    config = with_its_rod(config.with_own_rates())
    samples = read_rows(file, "samples")
    refusal = ""
    for settings in ({}, {"unreachable": "track"}):
        try:
            section = ReferenceSection.model_validate({"kind": "samples", **samples, **settings})
            Selection.from_config(config.model_copy(update={"reference": section}), model_rod(config))
        except (DaemonError, ModelError, ValidationError) as error:
            refusal = refusal or "; ".join(str(error).splitlines())
            continue
        return "".join(f" {key}={value}" for key, value in settings.items()), refusal
    return "", refusal


def columns_for(config: RigConfig) -> Columns:
    """Return what a rig's law follows: a direction where tendons end at several places, else a position, or a plane."""
    from tendond.daemon.control.laws import BENDING_PLANE, LAWS

    law = LAWS.get(config.control.law)
    if law is None or law.task_space is BENDING_PLANE:
        return "xz" if config.control.plane == "xz" else "yz"
    length = config.rod.backbone_length
    ends = {round(length if one.end is None else one.end, 9) for one in config.rod.tendon}
    return "direction" if len(ends) > 1 else "position"


def play(config_file: Path | None, file: Path, settings: list[str]) -> None:
    """Set a written path as the reference of an idle rig; see `tendond rig teach play --help`.

    Raises:
        TendondError: the file is not a path, no controller, or it refused.
    """
    load_config(config_file)  # an unreadable configuration is reported first
    set_reference([f"file={file}", "kind=samples", *settings], config_file)
