"""A process of its own around the `motioncapture` package: frames of a server as lines of JSON.

`python -m tendond.drivers.mocap.sdk_child TYPE SETTINGS`: the arguments of `motioncapture.connect`, SETTINGS in JSON.
Each line is `{"stamp_ns": ..., "objects": {name: [x, y, z (m), qw, qx, qy, qz]}}`, or `{"error": text}`, the last one.
It imports little, so that it is there quickly.
"""

import ctypes
import json
import signal
import sys
import time

DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)


def main(kind: str, settings: dict[str, str]) -> None:
    """Connect, then print a line per frame until the parent ends this process."""
    ctypes.CDLL(None).prctl(DIE_WITH_PARENT, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        import motioncapture

        client = motioncapture.connect(kind, settings)
        while True:
            client.waitForNextFrame()
            stamp_ns = time.monotonic_ns()
            objects = {}
            for name, body in client.rigidBodies.items():
                q = body.rotation
                objects[name] = [*map(float, body.position), q.w, q.x, q.y, q.z]
            print(json.dumps({"stamp_ns": stamp_ns, "objects": objects}), flush=True)
    except Exception as error:  # whatever the package raises is one line of the driver, which starts again
        print(json.dumps({"error": f"{type(error).__name__}: {error}".splitlines()[0]}), flush=True)
        raise SystemExit(1) from None


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]))
