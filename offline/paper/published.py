"""The paper's numbers: both tables, and the figures in its text."""

from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import tracking
from tendond.offline.logs.published import Published
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


def published_for(log: LogFile) -> Published | None:
    """Return the paper's figures of its simulation where a run goes to the paper's target; none elsewhere."""
    series = tracking(log)
    apart = abs(1000.0 * float(series.target[series.axis]) - FINAL_TIP_X_MM)
    return SIMULATION.get(log.config.control.law) if apart < 0.5 else None
