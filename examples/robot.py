"""Draw the robot of a published paper under tension, with its tendons and the strain along it.

python examples/robot.py robot.png
"""

import sys

from tendond.model.strain import StrainRod
from tendond.offline.plots.robot import robot_figure

rod = StrainRod.from_config("rao-2021")
tensions = ([0.0] * 6, [1.5, 0.0, 0.0, 0.0, 1.0, 0.0], [3.0, 0.0, 0.0, 0.0, 2.0, 0.0])  # N, one per tendon
robot_figure(rod, [rod.solve_static(rod.loads(tension=pull)) for pull in tensions]).savefig(sys.argv[1], dpi=110)
