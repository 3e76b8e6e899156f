"""The paper's robot, the default of every rod: configured, modelled, simulated.

Danesh & Janabi-Sharifi, table 1 and section 5. Diagonals are given as three numbers, in the body frame.
"""

LENGTH = 0.5
"""Length of the backbone, a steel wire [m]."""

RADIUS = 1e-3
"""Radius of the backbone [m]."""

YOUNGS_MODULUS = 190e9
"""Young's modulus of the backbone [Pa]."""

POISSON_RATIO = 0.3
"""Poisson's ratio of steel [-]; the paper does not give it."""

DENSITY = 17189.0
"""Density with disks, glue and markers [kg/m^3]."""

SHEAR_DAMPING = (0.0, 0.0, 0.0)
"""Diagonal of Bse [N s]."""

BENDING_DAMPING = (0.008, 0.008, 0.008)
"""Diagonal of Bbt [N m^2 s]."""

DRAG = (0.1, 0.1, 0.1)
"""Diagonal of C, square-law drag per length [kg/m^2]."""

GRAVITY = (-9.81, 0.0, 0.0)
"""World frame; the straight rod lies along +z [m/s^2]."""

TARGET_X = 0.34
"""Target of the experiment: x of the tip [m]."""

TENDON_POSITIONS = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))
"""(x, y) of each tendon in the cross-section [m]."""
