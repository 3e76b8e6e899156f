"""Checks of the bus: the controller, poses, the servo driver."""

import socket

import numpy as np

from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.schemas.messages import Mode
from tendond.schemas.remedies import clearing

SLOW_SHARE = 0.9
"""Fraction of the loop's rate below which poses are slow."""

OLD_SECONDS = 0.1
ONE_CLOCK_SECONDS = 10.0
"""Difference from this computer's clock above which a stamp is from another clock and gives no age."""


def controller(rig: Rig) -> CheckResult:
    """Check that the controller replies, or that its endpoint is free."""
    activity, endpoint, name = rig.activity, rig.config.bus.endpoint, rig.config.rig.name
    if activity.status is not None:
        status = activity.status
        finding = f"replies after {activity.reply_ms:.0f} ms: {status.mode.value} ({status.reason})"
        if status.loop.log_error:
            return warned(f"{finding}; {status.loop.log_error}", "free or repair the disk, then restart the controller")
        if status.mode is Mode.FAULT:
            return warned(finding, clearing(status.reason, has_servos=rig.config.servo is not None))
        if status.loop.missed_ticks > 0.001 * max(status.loop.cycles, 1000):
            return warned(
                f"{finding}; {status.loop.missed_ticks} of {status.loop.cycles} deadlines missed",
                "see priority, governor and idle states above, and other processes (top)",
            )
        return passed(finding)
    if activity.connected:
        return failed(
            f"something listens on {endpoint}, but no controller of rig '{name}' replies",
            "fix rig.name or bus.endpoint: each rig needs its own endpoint",
        )
    taken = _taken(endpoint)
    if taken:
        return failed(
            f"{endpoint} is in use, but not by a controller that admits this client", f"{taken}; {activity.error}"
        )
    return passed(f"not running; {endpoint} is free")


def poses(rig: Rig) -> CheckResult:
    """Check rate, age and validity of the tip poses."""
    activity, config = rig.activity, rig.config
    if not activity.connected:
        return warned("not checked: the controller is not running", "start it, then run this again")
    driver = "tendond mocap" if config.cameras is not None else "tendond mocap or tendond simulate"
    if activity.unreadable and not activity.poses:
        reasons = ", ".join(f"{count} {reason}" for reason, count in activity.unreadable.items())
        return failed(f"unreadable messages: {reasons}", "use the same version of tendond everywhere")
    if len(activity.poses) < 2:
        return failed("none received", f"start {driver}, and check that Tracker streams to this computer")
    arrivals = np.array([arrival for arrival, _ in activity.poses]) * 1e-9
    rate = (len(arrivals) - 1) / (arrivals[-1] - arrivals[0])
    gap = float(np.max(np.diff(arrivals)))
    finding = f"{rate:.0f} Hz, largest gap {gap * 1e3:.0f} ms"
    age = float(np.median([arrival - pose.stamp_ns for arrival, pose in activity.poses])) * 1e-9
    if abs(age) < ONE_CLOCK_SECONDS:
        finding += f", {age * 1e3:.0f} ms old"
    unseen = sum(not pose.valid for _, pose in activity.poses)
    if unseen == len(activity.poses):
        return failed(f"{finding}; none is valid", "see the driver's journal: is the tip occluded, is the base turned?")
    if gap > config.faults.pose_timeout:
        return failed(
            f"{finding}: a fault while tracking (faults.pose_timeout)", "check the network and Tracker's load"
        )
    if unseen or rate < SLOW_SHARE / config.loop.period or OLD_SECONDS < age < ONE_CLOCK_SECONDS:
        finding += f"; {unseen} not valid" if unseen else ""
        return warned(
            f"{finding}; the loop runs at {1.0 / config.loop.period:g} Hz",
            "raise Tracker's rate, check that the tip is visible everywhere; observer.delay should be the age",
        )
    return passed(finding)


def driver(rig: Rig) -> CheckResult | None:
    """Check the servo driver's report."""
    activity = rig.activity
    if rig.config.servo is None or not activity.connected:
        return None
    if not activity.states:
        return warned("the servo driver is not running", "start it: tendond servo")
    fault = activity.states[-1][1].fault
    if fault:
        return failed(f"reports: {fault}", "fix the cause, then: tendond servo reset")
    return passed(f"running without fault, {len(activity.states)} states per second")


def _taken(endpoint: str) -> str:
    """Explain why the endpoint cannot be listened on; empty if it can, or if it is another computer's."""
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
