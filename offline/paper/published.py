"""What the paper prints: both tables, and the figures that its text gives."""

from dataclasses import dataclass

TITLE = "Backstepping Control of Tendon-Driven Continuum Robots in Large Deflections Using the Cosserat Rod Model"
SOURCE = f"Danesh & Janabi-Sharifi, {TITLE}"


@dataclass(frozen=True)
class PaperRow:
    """A law's column in one of the paper's tables; named as in `tendond.offline.logs.metrics.Metrics`.

    Attributes:
        final_displacement_mm: of the tendon at the end, from the text; it gives none elsewhere.
    """

    tpl_mm: float
    settling_iterations: int
    overshoot_percent: float
    rise_iterations: int
    steady_state_error_mm: float
    final_displacement_mm: float | None = None


SIMULATION = {
    "backstepping": PaperRow(407.79, 22, 9.1, 7, 0.0, 58.0),
    "sliding_mode": PaperRow(1300.12, 43, 18.2, 7, 0.0),
}
"""Table 'Comparison of backstepping and sliding mode control under normal conditions', by law."""

EXPERIMENT = {
    "backstepping": PaperRow(379.07, 21, 5.7, 7, 0.0),
    "sliding_mode": PaperRow(1243.16, 44, 8.6, 10, 0.0),
}
"""Table 'Experimental comparison of backstepping and sliding mode control under normal conditions', by law."""

FINAL_TIP_X_MM = 340.0
INITIAL_TIP_Z_MM = 500.0

LAWS = tuple(SIMULATION)
