"""Bend the rod model by one tendon, from rest, and draw its shapes.

python examples/bend.py bend.png
"""

import sys

import matplotlib.pyplot as plt

from tendond.model import Rod, RodParameters

rod = Rod(RodParameters(length=0.5, radius=0.001))
for tension in range(0, 45, 4):
    state = rod.solve_static(tensions=[float(tension), 0.0, 0.0, 0.0])  # N, one per tendon
    x, _, z = 1e3 * rod.curve(state).T
    plt.plot(z, x, color=plt.get_cmap("viridis")(tension / 44), label=f"{tension} N" if tension % 8 == 4 else None)
plt.gca().set(
    xlabel="z [mm]", ylabel="x [mm]", aspect="equal", title="Half a metre of steel wire, pulled by one tendon"
)
plt.legend()
plt.savefig(sys.argv[1], dpi=110, bbox_inches="tight")
