"""The MuJoCo plant as a process in real time: a camera and a tendon driver as others would write them.

It knows the documented messages and a Zenoh client, and of tendond the MuJoCo plant alone. `python -m
tests.plants.mujoco_rig --endpoint tcp/127.0.0.1:7460 --mass 0.035` is the paper's robot with a weight of 35 g; it
prints the tip's position once a second, and with `--duration` a summary of the last 2 s as JSON.
"""

import argparse
import json
import math
import signal
import sys
import time

import numpy as np
import zenoh

from tests.plants.paper_robot import Robot
from tests.plants.rig import MujocoRig, RigSettings

CONNECT_SECONDS = 60.0
WATCHDOG_SECONDS = 0.5
"""Time without a command after which the drive releases the tendons [s]."""

WINDOW_SECONDS = 2.0
REPORT_SECONDS = 1.0


def options(arguments: list[str] | None = None) -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.plants.mujoco_rig", description=__doc__)
    parser.add_argument(
        "--endpoint", default="tcp/127.0.0.1:7460", help="endpoint of the controller (default: %(default)s)"
    )
    parser.add_argument("--rig", default="paper", help="first part of every key (default: %(default)s)")
    parser.add_argument("--mass", type=float, default=0.0, help="mass of a rigid body on the tip [kg]")
    parser.add_argument("--attach-at", type=float, default=0.0, help="time at which the body is attached [s]")
    parser.add_argument("--e-scale", type=float, default=1.0, help="E, as a multiple of 190 GPa")
    parser.add_argument("--damping-scale", type=float, default=1.0, help="Bbt, as a multiple of 0.008 N m^2 s")
    parser.add_argument("--delay", type=int, default=0, help="delay of a pose, in periods")
    parser.add_argument("--noise", type=float, default=0.0, help="standard deviation of a pose, each axis [m]")
    parser.add_argument("--rate", type=float, default=100.0, help="rate of the poses [Hz]")
    parser.add_argument(
        "--drive", choices=("tension", "displacement"), default="tension", help="command that is followed"
    )
    parser.add_argument("--duration", type=float, default=math.inf, help="duration [s] (default: until it is ended)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the noise")
    return parser.parse_args(arguments)


def connect(endpoint: str) -> zenoh.Session:
    """Open a client session of one endpoint, trying again until a controller listens.

    Raises:
        SystemExit: there is no controller in time.
    """
    zenoh.init_log_from_env_or("off")
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("transport/link/tx/queue/size/data", "16")
    deadline = time.monotonic() + CONNECT_SECONDS
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError:
            if time.monotonic() > deadline:
                raise SystemExit(f"no controller at {endpoint}") from None
            time.sleep(0.2)


def newest(commands: zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]) -> dict[str, object] | None:
    """Return the newest command since the last call; none without one."""
    command = None
    while (sample := commands.try_recv()) is not None:
        if sample.kind == zenoh.SampleKind.PUT:
            command = json.loads(sample.payload.to_bytes())
    return command


def main(arguments: list[str] | None = None) -> int:
    """Simulate in real time until ended, or for the given duration; return the exit status."""
    asked = options(arguments)
    paper, period = Robot(), 1.0 / asked.rate
    robot = Robot(
        youngs_modulus=asked.e_scale * paper.youngs_modulus,
        damping=asked.damping_scale * paper.damping,
        tip_mass=0.0 if asked.attach_at else asked.mass,
    )
    rig = MujocoRig(
        robot, RigSettings(period, asked.delay, asked.noise, asked.drive == "displacement", seed=asked.seed)
    )
    ended: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: ended.append(number))
    tips: list[np.ndarray] = []
    late = 0
    with connect(asked.endpoint) as session:
        commands = session.declare_subscriber(f"{asked.rig}/tendon/command", zenoh.handlers.RingChannel(8))
        states = session.declare_publisher(f"{asked.rig}/tendon/state", encoding="application/json", express=True)
        poses = session.declare_publisher(f"{asked.rig}/tip/pose", encoding="application/json", express=True)
        start = deadline = time.monotonic()
        heard, attached = start, not asked.attach_at
        tension = displacement = np.zeros(len(robot.tendons))
        armed, seq = False, 0
        while not ended and seq * period < asked.duration:
            head = {"version": 1, "seq": seq, "stamp_ns": time.monotonic_ns()}
            reported = {"displacement": rig.plant.displacement.tolist(), "tension": rig.plant.tension.tolist()}
            states.put(json.dumps({**head, **reported, "fault": ""}))
            position, orientation = (part.tolist() for part in rig.pose())
            poses.put(json.dumps({**head, "position": position, "orientation": orientation, "valid": True}))
            tips.append(rig.plant.position)
            del tips[: -round(WINDOW_SECONDS / period)]
            deadline += period
            late += time.monotonic() > deadline
            time.sleep(max(0.0, deadline - time.monotonic()))
            command = newest(commands)
            if command is not None:
                heard = time.monotonic()
                tension, displacement = np.array(command["tension"]), np.array(command["displacement"])
                armed = bool(command["armed"])
            elif time.monotonic() - heard > WATCHDOG_SECONDS:
                armed = False
            if not attached and seq * period >= asked.attach_at:
                rig.plant.hang(asked.mass)
                attached = True
            rig.advance(tension, displacement, armed)
            seq += 1
            if seq % round(REPORT_SECONDS / period) == 0:
                x, y, z = tips[-1].tolist()
                print(f"{seq * period:7.1f} s  tip {x:.4f} {y:.4f} {z:.4f} m  armed {armed}", flush=True)
    last = np.array(tips)
    summary = {
        "tip": last[-1].tolist(),
        "ripple_mm": float((last.max(axis=0) - last.min(axis=0)).max()) * 1e3,
        "armed": armed,
        "late": late,
        "periods": seq,
    }
    print(json.dumps(summary), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
