"""Checks of motion capture: what it needs on this computer, and who else could send poses."""

import math
import os
import time

from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.drivers.vicon.datastream import DataStreamSource, is_installed
from tendond.drivers.vicon.geometry import Alignment
from tendond.drivers.vicon.level import TILT_MAX, Level
from tendond.drivers.vicon.sockets import ViconError
from tendond.drivers.vicon.udp import UdpSource
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import CONFIG_VARIABLE

LEVEL_FRAMES = 50
"""Frames over which the base's direction is averaged."""

LEVEL_SECONDS = 2.0
"""Longest time to listen to motion capture [s]."""


def level(rig: Rig) -> CheckResult | None:
    """Check how the base stands against gravity, by its object in motion capture."""
    section, gravity = rig.config.vicon, rig.config.rod.gravity
    if section is None or not section.base or not any(gravity):
        return None
    if section.source == "datastream" and not is_installed():
        return None
    try:
        source = UdpSource(section) if section.source == "udp" else DataStreamSource(section)
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
            "start Tracker, and check vicon.base",
        )
    if base.tilted:
        if base.tilt > section.gravity_tolerance:
            return failed(base.objection(), "poses are invalid until then: vicon.gravity_tolerance")
        return warned(base.objection(), "the tip is off by the rod's length times the angle until then")
    tilt, limit = math.degrees(base.tilt), math.degrees(TILT_MAX)
    return passed(f"the base is within {limit:g} degrees of rod.gravity: {tilt:.1f}")


def sender(rig: Rig) -> CheckResult | None:
    """Check that only Tracker can send poses: its UDP stream bypasses the bus's access list."""
    section = rig.config.vicon
    if section is None:
        return None
    if section.source == "datastream":
        if not is_installed():
            return failed(
                "vicon.source = 'datastream' needs the motioncapture package", "pip install 'tendond[vicon-sdk]'"
            )
        return passed(f"the DataStream server {section.server} is connected to")
    if section.sender:
        return passed(f"packets to UDP port {section.port} are taken from {section.sender} alone")
    if is_guarded(rig.config) and section.address != "127.0.0.1":
        return warned(
            f"the bus has an access list, but anyone who reaches UDP port {section.port} can send poses",
            "set vicon.sender to the address of Tracker's computer, and vicon.address to that of the card towards it",
        )
    return passed(f"UDP port {section.port} keeps to the first that sends the robot's objects (vicon.sender is empty)")


def is_guarded(config: RigConfig) -> bool:
    """Check for an access list, or an endpoint beyond this machine."""
    return bool(os.environ.get(CONFIG_VARIABLE)) or not config.bus.is_loopback
