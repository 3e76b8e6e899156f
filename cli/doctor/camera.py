"""Checks of motion capture: what it needs on this computer, and who else could send poses."""

import math
import os
import time

from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.drivers.mocap.geometry import Alignment
from tendond.drivers.mocap.level import TILT_MAX, Level
from tendond.drivers.mocap.source import missing_library, open_source, place_of
from tendond.drivers.vicon.sockets import ViconError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import CONFIG_VARIABLE

LEVEL_FRAMES = 50
"""Frames over which the base's direction is averaged."""

OPEN_SECONDS = 5.0
"""Longest time for a webcam to open [s]."""

SEEN_MIN = 0.9
"""Part of the pictures that must show a tag."""

LEVEL_SECONDS = 2.0
"""Longest time to listen to motion capture [s]."""


def level(rig: Rig) -> CheckResult | None:
    """Check how the base stands against gravity, by its object in motion capture."""
    section, gravity = rig.config.cameras, rig.config.rod.gravity
    if section is None or not section.base or not any(gravity) or not section.knows_up or missing_library(section):
        return None
    try:
        source = open_source(section, rig.folder)
    except ViconError as error:
        return warned(
            f"the base was not compared with gravity: {error}",
            "a running driver reports a tilted base in its log; to measure it here, stop the driver",
        )
    base = Level(Alignment(section, gravity), gravity)
    frames, until = 0, time.monotonic() + LEVEL_SECONDS
    try:
        while frames < LEVEL_FRAMES and time.monotonic() < until:
            frame = source.receive()
            placement = None if frame is None else frame.objects.get(section.base)
            if placement is not None:
                base.see(placement)
                frames += 1
    finally:
        source.close()
    if not frames:
        return warned(
            f"the base was not compared with gravity: no pose of '{section.base}' arrived in {LEVEL_SECONDS:g} s",
            f"start {section.station}, and check {section.key}.base",
        )
    if base.tilted:
        if base.tilt > section.gravity_tolerance:
            return failed(base.objection(), f"poses are invalid until then: {section.key}.gravity_tolerance")
        return warned(base.objection(), "the tip is off by the rod's length times the angle until then")
    tilt, limit = math.degrees(base.tilt), math.degrees(TILT_MAX)
    return passed(f"the base is within {limit:g} degrees of rod.gravity: {tilt:.1f}")


def sender(rig: Rig) -> CheckResult | None:
    """Check what the cameras' driver needs, and who can send poses: UDP bypasses the bus's access list."""
    section = rig.config.cameras
    if section is None:
        return None
    if missing := missing_library(section):
        what, _, remedy = missing.partition(": ")
        return failed(what, remedy)
    if section.reader != "udp":
        return passed(f"poses come from {place_of(section)}, to which the driver connects")
    if section.sender:
        return passed(f"packets to UDP port {section.port} are taken from {section.sender} alone")
    if is_guarded(rig.config) and section.address != "127.0.0.1":
        return warned(
            f"the bus has an access list, but anyone who reaches UDP port {section.port} can send poses",
            f"set {section.key}.sender to the address of Tracker's computer, and {section.key}.address to that of the"
            " card towards it",
        )
    return passed(
        f"UDP port {section.port} keeps to the first that sends the robot's objects ({section.key}.sender is empty)"
    )


def tags(rig: Rig) -> CheckResult | None:
    """Check the pictures of a webcam: its calibration, its rate, and the tags in it."""
    section = rig.config.mocap
    if section is None or section.reader != "apriltag" or missing_library(section):
        return None
    from tendond.drivers.apriltag.calibration import CameraError
    from tendond.drivers.apriltag.source import TagSource

    try:
        source = TagSource(section, rig.folder)
    except CameraError as error:
        return failed(str(error), "poses in metres need the camera's intrinsics")
    names = sorted({section.tip, section.base} - {""})
    seen: dict[str, list[float]] = {name: [] for name in names}
    frames, began, until = 0, 0.0, time.monotonic() + LEVEL_SECONDS + OPEN_SECONDS
    try:
        while time.monotonic() < until:
            frame = source.receive()
            if frame is None:
                continue
            if not frames:
                began = time.monotonic()
                until = began + LEVEL_SECONDS
            frames += 1
            for name in names:
                if frame.objects.get(name) is not None:
                    seen[name].append(source.errors[name])
        passed_seconds = time.monotonic() - began
    finally:
        source.close()
    if not frames:
        news = "; ".join(source.news()) or f"no picture from {section.apriltag.video} in {OPEN_SECONDS:g} s"
        return failed(news, "connect the camera, and stop a driver that has it open; or set mocap.apriltag.video")
    rate = f"{frames / passed_seconds:.0f} pictures per second"
    if unseen := [f"'{name}'" for name, errors in seen.items() if not errors]:
        return failed(f"no pose of {' and '.join(unseen)} in {frames} pictures", "check tags, light and mocap.apriltag")
    found = ", ".join(
        f"'{name}' in {len(errors) / frames:.0%} (reprojection error {sum(errors) / len(errors):.2f} px)"
        for name, errors in seen.items()
    )
    if any(len(errors) < SEEN_MIN * frames for errors in seen.values()):
        return warned(f"{rate}: {found}", "occlusions: more light, a larger tag, or another place of the camera")
    return passed(f"{rate}: {found}")


def is_guarded(config: RigConfig) -> bool:
    """Check for an access list, or an endpoint beyond this machine."""
    return bool(os.environ.get(CONFIG_VARIABLE)) or not config.bus.is_loopback
