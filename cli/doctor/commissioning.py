"""Checks of the rig against its configuration: the measured rest, and the probe of the tendons, which moves the arm."""

import time

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask, ask_status
from tendond.cli.doctor.check import Result, Rig, bad, doubtful, good
from tendond.daemon.control.commissioning.averages import RestWatch
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.commissioning.rests import configured_rests
from tendond.daemon.control.state import rod_from_section
from tendond.model.errors import ModelError
from tendond.schemas.messages import ControlAction, Mode, Status

BLOCK = 25
"""Poses of a mean."""

PROBE_SECONDS = 60.0
POLL_SECONDS = 0.1
CONNECT_SECONDS = 2.0


def rest(rig: Rig) -> Result | None:
    """Whether the arm rests where the model does; not asked of one that is pulled."""
    status, seen = rig.heard.status, [pose for _, pose in rig.heard.poses if pose.valid]
    if not seen or (status is not None and status.mode not in (Mode.STARTING, Mode.IDLE)):
        return None
    try:
        rests = configured_rests(rig.config, rod_from_section(rig.config.rod, rig.config.loop.period).parameters)
    except ModelError as error:
        return bad(f"the model has no rest: {error}", "see [rod]")
    if rests is None:
        return doubtful("not compared: commissioning.rest = false", "leave it out")
    watch = RestWatch()
    for pose in seen:
        watch = watch.add(pose.position, pose.orientation, BLOCK)
    if objection := rest_objection(rests, watch):
        return bad(objection, "mend the camera's frame, or [rod]; arming is refused until then")
    return good("the arm rests where a right one may")


def probe(rig: Rig) -> Result | None:
    """What the tip does when each tendon is pulled a little, by the controller."""
    if not rig.probe:
        return None
    try:
        with open_client(rig.config.bus.endpoint, CONNECT_SECONDS) as session:
            reply = ask(session, rig.config.rig.name, ControlAction.PROBE)
            if not reply.done:
                return bad(reply.message, "mend the cause, then run this again")
            status = _ended(session, rig.config.rig.name)
    except BusError as error:
        return bad(f"not probed: {error}", "start the controller: tendond run")
    if status is None:
        return bad(f"it has not ended after {PROBE_SECONDS:g} s", "tendond stop")
    if status.mode is Mode.IDLE and "probed" in status.reason:
        return good(status.reason.removeprefix("released: "))
    return bad(status.reason, "mend the wiring, then: tendond reset")


def _ended(session: zenoh.Session, rig: str) -> Status | None:
    """The status once the probe is over; none where it does not end."""
    deadline = time.monotonic() + PROBE_SECONDS
    while time.monotonic() < deadline:
        status = ask_status(session, rig)
        if status.mode in (Mode.FAULT, Mode.IDLE):
            return status
        time.sleep(POLL_SECONDS)
    return None
