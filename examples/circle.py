"""Move the tip on a circle in space with all tendons, and draw the run.

python examples/circle.py circle.png
"""

import sys
import tempfile
from pathlib import Path

from tendond.offline.logs.log import load
from tendond.offline.plots.spatial import space_figure
from tendond.offline.simulate import simulate

config = {
    "control": {"law": "sensitivity"},
    "reference": {"kind": "circle", "radius": 0.2, "period": 3.0, "laps": 1},
}
with tempfile.TemporaryDirectory() as folder:
    log = Path(folder) / "circle.mcap"
    simulate(config, log, seconds=5.0)
    space_figure(load(log)).savefig(sys.argv[1], dpi=110)
