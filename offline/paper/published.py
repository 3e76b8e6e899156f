"""The paper's numbers: both tables, and the figures in its text."""

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import runs
from tendond.offline.logs.published import Published
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.robot import RodSection
from tendond.schemas.paper_robot import TARGET_X

TITLE = "Backstepping Control of Tendon-Driven Continuum Robots in Large Deflections Using the Cosserat Rod Model"
SOURCE = f"Danesh & Janabi-Sharifi, {TITLE}"


CAPTION = "paper: Danesh & Janabi-Sharifi,\nsimulation under normal conditions"

SIMULATION = {
    "backstepping": Published(407.79, 22, 9.1, 7, 0.0, 58.0, CAPTION),
    "sliding_mode": Published(1300.12, 43, 18.2, 7, 0.0, None, CAPTION),
}
"""Table 'Comparison of backstepping and sliding mode control under normal conditions', by law."""

EXPERIMENT = {
    "backstepping": Published(379.07, 21, 5.7, 7, 0.0),
    "sliding_mode": Published(1243.16, 44, 8.6, 10, 0.0),
}
"""Table 'Experimental comparison of backstepping and sliding mode control under normal conditions', by law."""

FINAL_TIP_X_MM = 1e3 * TARGET_X
INITIAL_TIP_Z_MM = 500.0

LAWS = tuple(SIMULATION)


ROBOT = (
    *("length", "radius", "youngs_modulus", "poisson_ratio", "density", "shear_damping", "bending_damping", "drag"),
    *("gravity", "tendon_positions", "tip_mass", "precurvature", "section", "tendon"),
)
"""Keys of [rod] that make the paper's robot."""


def published_for(log: LogFile) -> Published | None:
    """Return the paper's figures of its simulation where a log's first run is of its robot and its task; else none.

    The task: its target, along its exponential reference, without loads and injected faults.

    Raises:
        LogError: nothing tracks.
    """
    run = runs(log)[0]
    apart = abs(1000.0 * float(run.target[run.axis]) - FINAL_TIP_X_MM)
    if apart >= 0.5 or run.axis != 0 or run.injections or not _is_papers(log):
        return None
    return SIMULATION.get(log.config.control.law)


def _is_papers(log: LogFile) -> bool:
    """Return whether a log's configuration has the paper's robot, reference and loads."""
    config, paper = log.config, RodSection()
    rods = [config.rod, *([config.simulator.rod] if log.truth else [])]
    robot = all(getattr(rod, key) == getattr(paper, key) for rod in rods for key in ROBOT)
    reference = (config.reference.kind, config.reference.rate) == (ReferenceSection().kind, ReferenceSection().rate)
    changed = any(
        record.inputs.law is not None or record.inputs.reference is not None or record.inputs.jog is not None
        for record in log.records
    ) or any(record.tuned for record in log.records)
    loads = config.simulator.impacts or config.simulator.weight.mass > 0.0
    return robot and reference and not changed and not loads
