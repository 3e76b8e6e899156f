"""Open points of the paper and their decisions, from the configurations of the runs."""

from tendond.offline.paper.published import LAWS
from tendond.offline.paper.run import Runs
from tendond.offline.paper.scenarios import DISTURBANCE_CYCLES
from tendond.offline.paper.tables import markdown


def open_points(runs: Runs) -> str:
    """Write the table of open points."""
    config = runs["normal", LAWS[0]].scenario.config
    rod, edge = config.rod, runs["normal_edge", LAWS[0]].scenario.config
    first = runs["normal", LAWS[0]].tip[0]
    rows = [
        ("Poisson's ratio", f"{rod.poisson_ratio:g}", "steel; it enters only the shear and torsion"),
        ("gravity", f"{list(rod.gravity)} m/s²", "the weights act 'in -x, aligned with the gravitational force'"),
        (
            "start",
            f"at rest under gravity, tip at x = {1e3 * first[0]:.1f}, z = {1e3 * first[2]:.1f} mm",
            "the paper's is on the z axis, which is not an equilibrium under gravity",
        ),
        ("density", f"{rod.density:g} kg/m³", "the paper's recalculated value, not that of its table"),
        (
            "pretension",
            f"{config.pretension.tension:g} N (edge: {edge.pretension.tension:g} N)",
            "b_c vanishes in the straight rod, and a law that starts there cannot pull",
        ),
        (
            "bound on the inverse of b_c",
            f"a b_c smaller than {config.limits.input_gain_min:g} m/s²/N is inverted as "
            f"b'/{config.limits.input_gain_min**2:g}",
            "the inverse would grow without bound near the straight rod",
        ),
        (
            "inverse of b_c, and its sign",
            "b'/(b'b) of the agonist's column in the bending plane",
            "b_c is 3 x n of rank 1; as a number for x its sign changes when the tip passes 90 degrees; a "
            "vector "
            "needs no sign",
        ),
        (
            "a_c",
            "incremental: U = U applied + b_c^+ (wanted - present acceleration)",
            "n_s at the tip contains the tension now applied",
        ),
        (
            "tendons that pull",
            "one (edge: a pair)",
            "the paper does not say; one is sufficient to bend up",
        ),
        (
            "limits of the tension",
            f"{config.limits.tension_min:g} to {config.limits.tension_max:g} N (edge: {edge.limits.tension_max:g} N)",
            "tendons cannot push; the paper gives none",
        ),
        (
            "target of z",
            f"{1e3 * runs['normal', LAWS[0]].target[2]:.1f} mm, at once",
            "of the two rods with x = 340 mm the one bent further, whose tendon is the paper's; 0 cannot be reached",
        ),
        ("reference of x", f"340 mm (1 - exp(-{config.reference.rate:g} t))", "as written, with both derivatives"),
        (
            "velocity",
            "of the model, corrected by the measured tip (edge: differences of the measured tip)",
            "the paper does not say",
        ),
        (
            "scheme",
            f"Euler with {rod.nodes} nodes, BDF-alpha with {rod.alpha:g} and {1e3 * config.loop.period:g} ms, in "
            "model and plant",
            "as written",
        ),
        (
            "length of a run",
            f"{len(runs['normal', LAWS[0]].tip)} iterations",
            "not given; TPL of an oscillating law depends on it",
        ),
        (
            "metrics",
            "of x; settled within 5 % of the target, rise to 90 % of it, steady state the last 20",
            "they fit the paper's",
        ),
        ("weights", "a constant force at the tip along -x from the start", "as written"),
        ("duration of the disturbance", f"{DISTURBANCE_CYCLES} cycle", "not given"),
    ]
    return markdown(["open", "decision", "reason"], [list(row) for row in rows], numbers=False)
