"""Value of an identified model: points of `tendond study robustness` on plants that the controller does not know.

Their Young's modulus is off, and one has a tool on the tip; each is controlled by the model as built and as identified.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tendond.model.rod.tip_body import ball_inertia
from tendond.offline.identification.configured import with_values
from tendond.offline.identification.proof.rigs import BUILT, CONTROLLER, FACTORS, TIP_MASS
from tendond.offline.robustness.evaluate import PointResult, evaluate
from tendond.offline.robustness.points import Point
from tendond.schemas.config.rig import RigConfig, check_config

CASES: tuple[dict[str, Any], ...] = (
    {},
    {"delay_cycles": 2},
    {"lag_factor": 0.5},
    {"load_g": 50.0},
    {"drive": "displacement"},
    {"drive": "displacement", "delay_cycles": 1, "noise_mm": 0.1, "load_g": 20.0},
)
"""Plants that each factor of E is run on."""

MEASURES = ("settling_iterations", "path_overshoot_percent", "tpl_mm", "ripple_mm", "steady_error_mm", "force_error_n")


@dataclass(frozen=True)
class Match:
    """One plant, and what the controller believes.

    Attributes:
        plant: key of `FACTORS`. feedback: 'force' or 'offset'. case: key of `CASES`.
        values: identified values, by name; none: the controller knows the rod as built, but neither its Young's
            modulus nor what is on its tip.
    """

    plant: str
    feedback: str
    case: int
    values: dict[str, float] | None

    @property
    def point(self) -> Point:
        """The point as `tendond study robustness` names it."""
        return Point(
            "axes", "backstepping", self.feedback, youngs_factor=FACTORS[self.plant], **CASES[self.case]
        )  # fmt: skip


def as_built() -> RigConfig:
    """Return a controller that knows its rod up to Young's modulus, as in `tendond study robustness`."""
    return check_config(
        {"rod": BUILT, "limits": CONTROLLER["limits"] | {"displacement_rate": 5.0, "slack": 0.0}}, "proof"
    )


def matches(values: dict[str, dict[str, float]]) -> list[Match]:
    """Pair every point's run by the original model with the one by the identified model of its plant."""
    return [
        Match(plant, feedback, case, believed)
        for plant in FACTORS
        for feedback in ("force", "offset")
        for case in range(len(CASES))
        for believed in (None, values[plant])
    ]


def play(match: Match) -> PointResult:
    """Run it. Delay and lag are the point's: what was identified is of another camera and other servos."""
    base = as_built()
    known = {name: value for name, value in (match.values or {}).items() if name not in ("delay", "lag")}
    model = with_values(base, known).rod if known else base.rod
    mass = TIP_MASS[match.plant]
    built = base.rod.model_copy(update={"tip_mass": mass, "tip_inertia": ball_inertia(mass)})
    return evaluate(base.model_copy(update={"rod": built}), match.point, 0, model)


def table(played: Sequence[tuple[Match, PointResult]]) -> list[dict[str, Any]]:
    """Return a row for each point, with both models' measures."""
    rows: dict[tuple[str, str, int], dict[str, Any]] = {}
    for match, result in played:
        row = rows.setdefault(
            (match.plant, match.feedback, match.case),
            {"rig": match.plant, "plant": str(match.point), "feedback": match.feedback},
        )
        believed = "nominal" if match.values is None else "identified"
        row[believed] = {name: asdict(result)[name] for name in (*MEASURES, "meets", "mode", "reason")}
    return list(rows.values())


def means(rows: Sequence[dict[str, Any]]) -> dict[str, dict[str, dict[str, float]]]:
    """Average each measure over the points where both models have one, and count those that meet the goal."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for feedback in sorted({row["feedback"] for row in rows}):
        part = [row for row in rows if row["feedback"] == feedback]
        found[feedback] = {}
        for model in ("nominal", "identified"):
            values: dict[str, float] = {"points": len(part), "meet": sum(row[model]["meets"] for row in part)}
            for name in MEASURES:
                both = [row for row in part if None not in (row["nominal"][name], row["identified"][name])]
                if both:
                    values[name] = sum(row[model][name] for row in both) / len(both)
            found[feedback][model] = values
    return found
