"""Checks of motion capture: what it needs on this computer, and who else could send poses."""

import os

from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.drivers.vicon.datastream import is_installed
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import CONFIG_VARIABLE


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
    """Whether access to the bus is a concern: an access list, or an endpoint beyond this machine."""
    return bool(os.environ.get(CONFIG_VARIABLE)) or not config.bus.is_loopback
