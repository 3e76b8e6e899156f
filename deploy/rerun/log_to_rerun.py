"""A log in Rerun: the rod, its tendons, tip, trail and target in space, every number of the cycle as a curve.

pip install tendond rerun-sdk
python log_to_rerun.py run.mcap                  # opens the viewer
python log_to_rerun.py run.mcap --save run.rrd   # or writes a recording
python log_to_rerun.py run.mcap --serve          # or serves the viewer to a browser

Rerun reads the MCAP file by itself as well, but shows JSON messages as text.
"""

import argparse
import os
import signal
import sys
from collections import deque
from contextlib import suppress
from pathlib import Path
from urllib.parse import quote

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from tendond.offline.logs import load
from tendond.offline.logs.log import load as load_log

TRAIL_SECONDS = 3.0


def main() -> None:
    """Send a log to the viewer, or to a file."""
    parser = argparse.ArgumentParser(description="Show a log of tendond in Rerun.")
    parser.add_argument("log", type=Path)
    parser.add_argument("--save", type=Path, help="recording to write instead of opening the viewer")
    parser.add_argument("--serve", action="store_true", help="serve the viewer to a browser until Ctrl-C")
    options = parser.parse_args()
    if options.save is None and not options.serve and not has_display():
        parser.error("no display to open the viewer on: give --save run.rrd, or --serve for a browser")
    run = load(options.log)
    rr.init("tendond", spawn=options.save is None and not options.serve)
    if options.save is not None:
        rr.save(options.save)
    elif options.serve:
        address = rr.serve_grpc()
        rr.serve_web_viewer(open_browser=False, connect_to=address)
    time = run["time"]
    for name, array in run.arrays.items():
        if array.dtype.kind not in "fib" or name == "time":
            continue
        for i, column in enumerate(np.atleast_2d(array.T)):
            entity = f"numbers/{name.replace('.', '/')}" + (f"/{i}" if array.ndim > 1 else "")
            kept = np.isfinite(column)
            columns = rr.Scalars.columns(scalars=column[kept].astype(np.float64))
            rr.send_columns(entity, indexes=[rr.TimeColumn("cycle", duration=time[kept])], columns=columns)
    log = load_log(options.log)
    for (tick, points), tendons in zip(log.shapes, log.tendons, strict=True):
        rr.set_time("cycle", duration=tick * run.config.loop.period)
        rr.log("rod", rr.LineStrips3D([points], radii=0.002))
        rr.log("tendons", rr.LineStrips3D(tendons, radii=0.0005, colors=[(128, 128, 128)]))
    trail: deque[NDArray[np.float64]] = deque(maxlen=round(TRAIL_SECONDS / run.config.loop.period))
    for at, position, wanted, target in zip(
        time, run["measured"], run["reference.position"], run["reference.target"], strict=True
    ):
        rr.set_time("cycle", duration=at)
        if np.all(np.isfinite(position)):
            trail.append(position)
            rr.log("tip", rr.Points3D([position], radii=0.006))
            rr.log("trail", rr.LineStrips3D([np.array(trail)], radii=0.001, colors=[(64, 115, 180)]))
        rr.log("reference", rr.Points3D([wanted], radii=0.006, colors=[(230, 115, 25)]))
        rr.log("target", rr.Points3D([target], radii=0.004, colors=[(200, 40, 40)]))
    if options.serve:
        print(f"open http://localhost:9090/?url={quote(address, safe='')} in a browser; Ctrl-C ends", flush=True)
        with suppress(KeyboardInterrupt):
            signal.pause()


def has_display() -> bool:
    """Whether a window can be opened: on Linux the viewer waits for ever, or fails, without X11 and Wayland."""
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


if __name__ == "__main__":
    main()
