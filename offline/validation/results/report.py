"""A validation as text: a page in Markdown, and plain data."""

from dataclasses import asdict
from typing import Any

import numpy as np

from tendond.offline.validation.evaluate import JUMP, Validation
from tendond.offline.validation.results.metrics import Errors


def as_json(found: Validation, target: float | None) -> dict[str, Any]:
    """Return the result as plain data, SI units."""
    return {
        "dataset": found.poses.name,
        "source": found.poses.source,
        "poses": len(found.poses),
        "fitted": found.fitted,
        "held_out_rms_target": target,
        "models": {
            one.name: {
                "parameters": one.parameters,
                "training": asdict(one.training),
                "held_out": asdict(one.held_out),
            }
            for one in found.models
        },
        "by_tendon": [asdict(one) for one in found.by_tendon],
        "parameters": [{**asdict(one), "identifiable": one.identifiable} for one in found.knowledge],
        "inseparable": [list(one) for one in found.inseparable],
        "selection": [asdict(one) for one in found.trials],
        "repeatability": asdict(found.scatter),
        "jumps": [asdict(one) for one in found.jumps],
        "failed": found.failed,
    }


def header() -> list[str]:
    """Return the heading of the table of models."""
    return ["model", "parameters", "training RMS", "held-out RMS", "50 %", "90 %", "95 %", "max"]


def lines(found: Validation) -> list[list[str]]:
    """Return the table of models, lengths in mm."""
    return [
        [one.name, str(one.parameters), _mm(one.training.rms), _mm(one.held_out.rms),
         *(_mm(value) for value in one.held_out.percentiles), _mm(one.held_out.largest)]
        for one in found.models
    ]  # fmt: skip


def remarks(found: Validation, target: float | None) -> list[str]:
    """Return what is to be said besides the table, a sentence each."""
    rod, held = found.model("rod"), int(np.count_nonzero(found.poses.held_out))
    said = [
        f"{len(found.poses)} poses in {len(found.poses.label)} blocks; {held} held out, {found.fitted} fitted; "
        "errors of the tip in mm."
    ]
    if target is not None:
        word = "met" if rod.held_out.rms <= target else "MISSED"
        said.append(f"Target of the rod's held-out RMS: {_mm(target)} mm, {word}.")
    scatter = found.scatter
    if scatter.pairs:
        said.append(
            f"Repeatability: {scatter.pairs} pairs of poses with commands within {_mm(scatter.near)} mm and at least "
            f"{scatter.apart} poses apart scatter by {_mm(scatter.rms)} mm (median {_mm(scatter.median)}); the rod "
            f"without friction is {_mm(scatter.model_rms)} mm off there: up to {100.0 * scatter.share:.0f} % of its "
            "squared error is out of reach of any function of the command (commands within that distance count as "
            "equal)."
        )
    if found.jumps:
        largest = max(found.jumps, key=lambda one: one.size)
        said.append(
            f"At {len(found.jumps)} places the rod's error changes by more than {_mm(JUMP)} mm between successive "
            "poses with nearly the same commands, and stays; the largest change is "
            f"{_mm(largest.size)} mm at pose {largest.pose}."
        )
    if found.failed:
        said.append(f"{found.failed} poses have no equilibrium within the solver's iterations.")
    dark = [one.name for one in found.knowledge if not one.identifiable]
    if dark:
        said.append(f"Not identifiable, given by their priors: {', '.join(dark)}.")
    far = [f"{one.name} ({one.off:+.1f})" for one in found.knowledge if abs(one.off) > 3.0]
    if far:
        said.append(f"More than three sigmas off their priors: {', '.join(far)}.")
    if found.inseparable:
        pairs = (f"{one} and {other} ({r:+.3f})" for one, other, r in found.inseparable[:8])
        said.append(f"Cannot be told apart (correlation): {', '.join(pairs)}.")
    for trial in found.trials:
        change = trial.predicted if trial.found is None else trial.found
        said.append(f"Group {trial.group}: BIC {change:+.0f}, {'taken' if trial.taken else 'left out'}.")
    return said


def page(found: Validation, target: float | None) -> str:
    """Return the report in Markdown."""
    text = [f"# {found.poses.name}", "", f"Source: {found.poses.source}.", "", *_table(header(), lines(found)), ""]
    text += [*(f"- {one}" for one in remarks(found, target)), "", "## By tendon", ""]
    rows = [[str(i), *_errors(one)] for i, one in enumerate(found.by_tendon)]
    text += _table(["pulled most", "poses", "RMS", "50 %", "90 %", "95 %", "max"], rows)
    text += ["", "## Parameters", ""]
    text += _table(
        ["parameter", "value", "sigma", "unit", "sigma / prior's", "off the prior [sigma]"],
        [
            [one.name, f"{one.value:.4g}", f"{one.sigma:.2g}", one.unit, f"{one.shrink:.2f}", f"{one.off:+.1f}"]
            for one in found.knowledge
        ],
    )
    return "\n".join(text) + "\n"


def _errors(one: Errors) -> list[str]:
    return [str(one.count), _mm(one.rms), *(_mm(value) for value in one.percentiles), _mm(one.largest)]


def _table(head: list[str], rows: list[list[str]]) -> list[str]:
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]


def _mm(length: float) -> str:
    return "-" if np.isnan(length) else f"{1e3 * length:.2f}"
