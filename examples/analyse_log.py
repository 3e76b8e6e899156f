"""Read a log into a notebook: arrays with names and units, a row per cycle.

python examples/analyse_log.py run.mcap
"""

import sys

import numpy as np

from tendond.offline.logs import load

run = load(sys.argv[1])
print(f"{run.path}: {len(run)} cycles of rig '{run.config.rig.name}', law {run.config.control.law}")

# Every field of the cycle's record by its name, with its unit; `run.names` has them all.
for name in ("time", "measured", "reference.position", "command.displacement", "tension_estimate", "observer.force"):
    print(f"  {name}: shape {run[name].shape}, unit {run.units[name]}")

# Masks are arrays too: the part that tracks.
tracks = run["mode"] == "tracking"
error = np.linalg.norm(run["measured"][tracks] - run["reference.position"][tracks], axis=1)
print(f"error while tracking: {1e3 * error.mean():.2f} mm on average, {1e3 * error[-1]:.2f} mm at the end")

# What a cycle does not have is NaN: a law's terms while no law runs.
z1 = run["terms.z1"] if "terms.z1" in run.names else run["terms.error"]
print(f"the law ran in {np.isfinite(z1[:, 0]).sum()} cycles")

# One-dimensional columns with units in their names; run.to_pandas() is a DataFrame of them.
columns = run.columns()
print(f"{len(columns)} columns, for instance {', '.join(list(columns)[:6])}")
