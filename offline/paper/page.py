"""The page of a reproduction: every number in it is computed from the runs, the configuration or the paper's tables."""

import re

from tendond import __version__
from tendond.offline.paper.account import account
from tendond.offline.paper.lyapunov import CAUSES, find_rises, measured_rate, rate_of
from tendond.offline.paper.open_points import open_points
from tendond.offline.paper.published import EXPERIMENT, LAWS, SIMULATION, SOURCE
from tendond.offline.paper.run import Runs
from tendond.offline.paper.scenarios import IMPACT_CYCLES, IMPACT_PLACE, IMPACT_SIZE, IMPACTS, SEED, STRING, WEIGHTS_G
from tendond.offline.paper.tables import bounds, compared, markdown, overview

VARIANTS = ("normal", "normal_direct", "normal_papers_z", "normal_rk6", "normal_edge", "normal_edge_exchanged")
LOADS = (
    "disturbance",
    "disturbance_edge",
    *(f"weight_{grams}g{suffix}" for grams in WEIGHTS_G for suffix in ("", "_yielding", "_edge")),
)
RIG_LOADS = (*(f"rig_weight_{grams}g" for grams in WEIGHTS_G), "rig_impacts")


def page(runs: Runs, form: str = "png") -> str:
    """Write the page in Markdown, for the folder of the figures, which are files with the ending `form`."""
    text = _page(runs)
    return text if form == "png" else re.sub(r"(!\[[^\]]*\]\(\w+)\.png\)", rf"\1.{form})", text)


def _page(runs: Runs) -> str:
    parts = [
        "# The paper reproduced",
        f"{SOURCE}: its simulations and the scenarios of its experiment, run by tendond {__version__} (`tendond study "
        "paper`) "
        "offline, in lockstep with the simulator, by the same cycle as on a rig. The paper's numbers are from its "
        "tables; all others on this page are computed by the run that wrote it. An iteration is a cycle of "
        f"{1e3 * runs['normal', LAWS[0]].scenario.config.loop.period:g} ms, counted from the start of tracking.",
        _bounds(runs),
        "## The simulation\n\n### Same information\n\nBoth laws get their inputs from the observer; the plant is the "
        "model, "
        "driven by tension. This is the paper's simulation as written, except for the reachable z.",
        compared(SIMULATION, runs, "normal"),
        _figure("normal", "Normal conditions, both laws with the same information"),
        _figure("configurations", "Configurations, same information"),
        "### Edge of stability",
        account(runs, "edge"),
        compared(SIMULATION, runs, "normal_edge"),
        _figure("normal_edge", "Normal conditions, edge of stability"),
        _figure("configurations_edge", "Configurations, edge of stability"),
        "### Cause of the difference",
        account(runs, "contrast"),
        "### Variants",
        overview(runs, VARIANTS, SIMULATION),
        account(runs, "variants"),
        "## Weights and a disturbance",
        account(runs, "loads"),
        overview(runs, LOADS),
        *(
            _figure(f"{what}_{law}{suffix}", f"{what.capitalize()}, {law.replace('_', ' ')}{condition}")
            for suffix, condition in (("", ""), ("_edge", ", edge of stability"))
            for what in ("weights", "disturbance")
            for law in LAWS
        ),
        "## Estimate of the load",
        account(runs, "force"),
        _figure("force", "A weight hung on, and the observer's estimate"),
        "## The experiment, on a rig-like plant",
        account(runs, "rig"),
        compared(EXPERIMENT, runs, "rig_normal"),
        _figure("experiment_normal", "Rig-like plant, normal conditions"),
        "The same rig with velocities from differences of the measured tip (the paper's laws take the tip's position "
        "from Vicon; the paper does not give the source of their velocity):",
        compared(EXPERIMENT, runs, "rig_normal_direct"),
        _figure("experiment_normal_direct", "Rig-like plant, measured velocity"),
        f"Weights hang on a string of {STRING:g} m and swing, so that their pull varies while the arm moves. {IMPACTS} "
        f"impacts of {IMPACT_SIZE[0]:g} to {IMPACT_SIZE[1]:g} N for {IMPACT_CYCLES[0]} to {IMPACT_CYCLES[1]} cycles, "
        "of "
        f"random direction, at random places from {IMPACT_PLACE[0]:g} to {IMPACT_PLACE[1]:g} of the rod's length and "
        "at "
        f"random times, are drawn with seed {SEED}, the same for both laws.",
        overview(runs, RIG_LOADS),
        account(runs, "rig loads"),
        _figure("experiment_weights", "Hanging weights"),
        _figure("experiment_impacts", "Random impacts"),
        *(_figure(f"snapshots_{law}", f"Snapshots, {law.replace('_', ' ')}") for law in LAWS),
        "## The Lyapunov functions",
        _lyapunov(runs),
        "## What the paper leaves open",
        open_points(runs),
        "## Files\n\n`simulation.csv`, `experiment.csv`: the tables above, one line per criterion. `scenarios.csv`: "
        "every "
        "metric of every run. `results.json`: in the form of the paper's results, ours with the same information; "
        "`results_edge.json`: the same at the edge of stability.",
    ]
    return "\n\n".join(parts) + "\n"


def _bounds(runs: Runs) -> str:
    """Compare each result with its tolerance."""
    lines = []
    for bound in bounds():
        one, title = bound.criterion, runs[bound.scenario, bound.law].scenario.title
        paper = getattr(SIMULATION[bound.law], one.field)
        lines.append(
            [
                f"{title}, {bound.law.replace('_', ' ')}: {one.label} [{one.unit}]",
                one.text(paper),
                f"{max(0.0, bound.low):.4g} to {bound.high:.4g}",
                one.text(bound.value(runs)),
                "yes" if bound.met(runs) else "**no**",
            ]
        )
    return "## Tolerances\n\n" + markdown(["", "paper", "required", "ours", "met"], lines)


def _lyapunov(runs: Runs) -> str:
    lines = []
    for scenario in ("normal", "normal_edge"):
        for law in LAWS:
            run = runs[scenario, law]
            found = find_rises(run)
            lines.append(
                [
                    f"{run.scenario.title}, {law.replace('_', ' ')}",
                    str(found.falls),
                    *(str(len(found.of(cause))) for cause in CAUSES),
                    f"{2.0 * rate_of(run):.1f}",
                    f"{measured_rate(run):.1f}".replace("nan", "does not stay there"),
                ]
            )
    head = ["cycles over which V", "falls", *(f"rises: {cause}" for cause in CAUSES), "theory [1/s]", "measured [1/s]"]
    causes = "\n".join(f"- {cause}: {meaning}." for cause, meaning in CAUSES.items())
    return "\n\n".join(
        [
            "Backstepping: V = (z1'z1 + z2'z2)/2 with V' = -alpha1 z1'z1 - alpha2 z2'z2. Sliding mode: V = S'S/2 with "
            "V' = -k S'S - epsilon |S|. Both decay at 2 alpha2 and 2 k [1/s] when the error is in the velocity-like "
            "term; `measured` is the decay from the maximum of V until it stays below a ten-thousandth of it.",
            _figure("lyapunov", "Lyapunov functions"),
            markdown(head, lines),
            causes,
            account(runs, "lyapunov"),
        ]
    )


def _figure(name: str, caption: str) -> str:
    return f"![{caption}]({name}.png)"
