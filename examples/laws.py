"""Push the arm under both of the paper's laws, and compare how they come back.

python examples/laws.py laws.png
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from tendond.offline.simulate import simulate

PUSH = {"time": 1.0, "duration": 0.05, "force": (3.0, 0.0, 0.0)}  # s, s, N
plt.figure(figsize=(7, 3.2), layout="constrained")
for law in ("backstepping", "sliding_mode"):
    config = {"control": {"law": law}, "simulator": {"impacts": [PUSH], "mocap": {"noise": 1e-4}, "seed": 1}}
    with tempfile.TemporaryDirectory() as folder:
        run = simulate(config, Path(folder) / "run.mcap", seconds=2.0)
    tracks = run["mode"] == "tracking"
    error = np.linalg.norm(run["measured"] - run["reference.position"], axis=1)[tracks]
    plt.semilogy(run["time"][tracks], 1e3 * error, label=law.replace("_", " "))
plt.axvline(PUSH["time"], color="grey", ls=":", label="push of 3 N for 50 ms")
plt.gca().set(xlabel="time [s]", ylabel="error of the tip [mm]", title="Rise, and a push")
plt.legend()
plt.savefig(sys.argv[1], dpi=110)
