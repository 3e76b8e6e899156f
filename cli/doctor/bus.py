"""Checks of the bus: the controller, poses, the servo driver."""

import socket

import numpy as np

from tendond.cli.doctor.check import Result, Rig, bad, doubtful, good
from tendond.schemas.messages import Mode

SLOW_SHARE = 0.9
"""Of the loop's rate, below which poses are slow."""

OLD_SECONDS = 0.1
ONE_CLOCK_SECONDS = 10.0
"""Stamps further from this computer's clock than this are another's, and give no age."""


def controller(rig: Rig) -> Result:
    """Whether it answers, or could listen."""
    heard, endpoint, name = rig.heard, rig.config.bus.endpoint, rig.config.rig.name
    if heard.status is not None:
        status = heard.status
        finding = f"answers after {heard.answer_ms:.0f} ms: {status.mode.value} ({status.reason})"
        if status.loop.log_error:
            return doubtful(f"{finding}; {status.loop.log_error}", "free or mend the disk, then start it anew")
        if status.mode is Mode.FAULT:
            return doubtful(finding, "mend the cause, then: tendond reset")
        if status.loop.missed_ticks > 0.001 * max(status.loop.cycles, 1000):
            return doubtful(
                f"{finding}; {status.loop.missed_ticks} of {status.loop.cycles} deadlines missed",
                "see priority, governor and idle states above, and what else runs (top)",
            )
        return good(finding)
    if heard.connected:
        return bad(
            f"something listens on {endpoint}, but no controller of rig '{name}' answers",
            "mend rig.name or bus.endpoint: several rigs need an endpoint each",
        )
    taken = _taken(endpoint)
    if taken:
        return bad(f"{endpoint} is taken, and not by a controller that lets us in", f"{taken}; {heard.error}")
    return good(f"none runs; {endpoint} is free")


def poses(rig: Rig) -> Result:
    """Whether tip poses come, how often, how old, and whether they are valid."""
    heard, config = rig.heard, rig.config
    if not heard.connected:
        return doubtful("not listened for: no controller runs", "start it, then run this again")
    driver = "tendond rig vicon" if config.vicon is not None else "tendond rig vicon or tendond simulate"
    if heard.unreadable and not heard.poses:
        reasons = ", ".join(f"{count} {reason}" for reason, count in heard.unreadable.items())
        return bad(f"what comes cannot be read: {reasons}", "use the same version of tendond everywhere")
    if len(heard.poses) < 2:
        return bad("none comes", f"start {driver}, and see that Tracker streams to this computer")
    arrivals = np.array([arrival for arrival, _ in heard.poses]) * 1e-9
    rate = (len(arrivals) - 1) / (arrivals[-1] - arrivals[0])
    gap = float(np.max(np.diff(arrivals)))
    finding = f"{rate:.0f} a second, {gap * 1e3:.0f} ms between two at most"
    age = float(np.median([arrival - pose.stamp_ns for arrival, pose in heard.poses])) * 1e-9
    if abs(age) < ONE_CLOCK_SECONDS:
        finding += f", {age * 1e3:.0f} ms old"
    unseen = sum(not pose.valid for _, pose in heard.poses)
    if unseen == len(heard.poses):
        return bad(
            f"{finding}; not one is valid", "see why in the driver's journal: is the tip hidden, is the base turned?"
        )
    if gap > config.faults.pose_timeout:
        return bad(f"{finding}: a fault while tracking (faults.pose_timeout)", "see the network and Tracker's load")
    if unseen or rate < SLOW_SHARE / config.loop.period or OLD_SECONDS < age < ONE_CLOCK_SECONDS:
        finding += f"; {unseen} not valid" if unseen else ""
        return doubtful(
            f"{finding}; the loop has {1.0 / config.loop.period:g} cycles a second",
            "raise Tracker's rate, see that the tip is seen from everywhere; observer.delay should be the age",
        )
    return good(finding)


def driver(rig: Rig) -> Result | None:
    """What the servo driver says of itself."""
    heard = rig.heard
    if rig.config.servo is None or not heard.connected:
        return None
    if not heard.states:
        return doubtful("no servo driver runs", "start it: tendond servo")
    fault = heard.states[-1][1].fault
    if fault:
        return bad(f"reports: {fault}", "mend the cause, then: tendond servo reset")
    return good(f"runs without fault, {len(heard.states)} states a second")


def _taken(endpoint: str) -> str:
    """Why the endpoint could not be listened on; empty if it could, or if it is another computer's."""
    host, _, port = endpoint.partition("/")[2].rpartition(":")
    kind = socket.SOCK_DGRAM if endpoint.startswith("quic") else socket.SOCK_STREAM
    try:
        family, _, _, _, address = socket.getaddrinfo(host.strip("[]"), int(port), type=kind)[0]
        with socket.socket(family, kind) as probe:
            if kind is socket.SOCK_STREAM:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        return f"{error.strerror or error}: end what listens there, or change bus.endpoint"
    return ""
