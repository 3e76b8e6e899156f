"""Hang weights on the tip, and estimate their force from the tip's motion alone.

python examples/weight.py weight.png
"""

import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

from tendond.offline.simulate import simulate

ATTACHED = 1.5  # s
plt.figure(figsize=(7, 3.2), layout="constrained")
for number, mass in enumerate((0.01, 0.03, 0.05)):  # kg
    simulator = {"weight": {"mass": mass, "time": ATTACHED}, "mocap": {"noise": 1e-4}, "seed": 1}
    with tempfile.TemporaryDirectory() as folder:
        run = simulate({"simulator": simulator}, Path(folder) / "weight.mcap", seconds=4.0)
    tracks = run["mode"] == "tracking"
    plt.plot(run["time"][tracks], run["observer.force"][tracks, 0], f"C{number}", label=f"{1e3 * mass:.0f} g")
    plt.axhline(-9.81 * mass, color=f"C{number}", ls=":")
plt.axvline(ATTACHED, color="grey", lw=0.8)
plt.title("Estimated force of weights on the tip, and their true ones (dotted)")
plt.gca().set(xlabel="time [s]", ylabel="force in x [N]")
plt.legend()
plt.savefig(sys.argv[1], dpi=110)
