"""Published figures of a run, to be shown beside its own."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Published:
    """Metrics of a run as a paper prints them; named as in `tendond.offline.logs.metrics.Metrics`.

    Attributes:
        final_displacement_mm: the tendon's displacement at the end; none where the paper does not give it.
        source: source of the figures, in words.
    """

    tpl_mm: float
    settling_iterations: int
    overshoot_percent: float
    rise_iterations: int
    steady_state_error_mm: float
    final_displacement_mm: float | None = None
    source: str = ""
