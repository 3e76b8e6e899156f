"""Checks of the rig against its configuration: the measured rest, and the probe of the tendons, which moves the arm."""

import time

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask, ask_status
from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.daemon.control.commissioning.averages import RestWatch
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.commissioning.rest_grid import configured_rests
from tendond.model.errors import ModelError
from tendond.model.rods.selection import model_rod
from tendond.schemas.messages import Mode, Status
from tendond.schemas.requests import ControlAction

BLOCK = 25
"""Number of poses that are averaged."""

PROBE_SECONDS = 60.0
POLL_SECONDS = 0.1
CONNECT_SECONDS = 2.0


def rest(rig: Rig) -> CheckResult | None:
    """Compare the measured rest with the model's; only while no tendon pulls."""
    status, valid = rig.activity.status, [pose for _, pose in rig.activity.poses if pose.valid]
    if not valid or (status is not None and status.mode not in (Mode.STARTING, Mode.IDLE)):
        return None
    try:
        rests = configured_rests(rig.config, model_rod(rig.config).parameters)
    except ModelError as error:
        return failed(f"the model has no rest: {error}", "see [rod]")
    if rests is None:
        return warned("not compared: commissioning.rest = false", "remove the key")
    watch = RestWatch()
    for pose in valid:
        watch = watch.add(pose.position, pose.orientation, BLOCK)
    if objection := rest_objection(rests, watch):
        return failed(objection, "fix the camera's frame, or [rod]; arming is refused until then")
    return passed("the arm rests where the model predicts")


def probe(rig: Rig) -> CheckResult | None:
    """Have the controller pull each tendon slightly, and compare the tip's motion with the model's."""
    if not rig.probe:
        return None
    try:
        with open_client(rig.config.bus.endpoint, CONNECT_SECONDS) as session:
            reply = ask(session, rig.config.rig.name, ControlAction.PROBE)
            if not reply.done:
                return failed(reply.message, "fix the cause, then run this again")
            status = _ended(session, rig.config.rig.name)
    except BusError as error:
        return failed(f"not probed: {error}", "start the controller: tendond run")
    if status is None:
        return failed(f"it has not finished after {PROBE_SECONDS:g} s", "tendond stop")
    if status.mode is Mode.IDLE and "probed" in status.reason:
        return passed(status.reason.removeprefix("released: "))
    return failed(status.reason, "fix the wiring, then: tendond reset")


def _ended(session: zenoh.Session, rig: str) -> Status | None:
    """Wait for the end of the probe and return the status; none if it does not end."""
    deadline = time.monotonic() + PROBE_SECONDS
    while time.monotonic() < deadline:
        status = ask_status(session, rig)
        if status.mode in (Mode.FAULT, Mode.IDLE):
            return status
        time.sleep(POLL_SECONDS)
    return None
