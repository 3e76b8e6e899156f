"""Report of an identification: page, numbers, files."""

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from tendond.offline.files import write_whole
from tendond.offline.identification.fitting.candidate import Trial
from tendond.offline.identification.results.parameter_file import free_name, parameter_file
from tendond.offline.identification.results.residual import Learned, summary
from tendond.offline.identification.results.result import Found, Identification

MISSING = 2.0
"""Ratio of residuals to the poses' noise above which the report warns of a deficient model."""


DECIDED = {"prior": "the prior", "data": "the data", "both": "data and prior"}


def report(result: Identification, file: str) -> str:
    """Write the page in Markdown."""
    return "\n".join(_page(result, file)) + "\n"


def remark(found: Found) -> str:
    """Say why a parameter was not found, or whether data or prior decide."""
    if found.prior is None or not found.found:
        return found.why
    return f"prior {found.prior.value:.6g} +- {found.prior.sigma:.2g}; decided by {DECIDED[found.decided]}"


def change_of(trial: Trial) -> str:
    """Format the change of the criterion; none of what was not tried."""
    return f"{trial.change:+.1f}" if trial.change else "-"


def fitted_to(result: Identification) -> str:
    """Describe what of the logs was fitted to."""
    if not result.statics:
        return "the motion"
    return f"{sum(len(one.recording.pose_times) for one in result.simulations)} rests, one after the other"


def warnings(result: Identification) -> list[str]:
    """List warnings about the result, one line each."""
    lines = [finding.text for finding in result.findings]
    if result.rms > MISSING * result.noise:
        lines.append(
            f"the residuals, {result.rms * 1e3:.3f} mm, are {result.rms / result.noise:.1f} times the poses' noise: "
            "the model is incomplete; the standard errors do not include the resulting error"
        )
    if result.drive == "command" and not result.statics:
        lines.append(
            "the servos' reports were not used: what a servo does beyond a first-order lag (backlash, a profile of "
            "speed) is attributed to the rod, mostly to Bbt and C"
        )
    for recorded in result.held_out:
        if not recorded.used and recorded.fitted_rms > recorded.nominal_rms:
            lines.append(
                f"on {recorded.name}, which was held out, the configuration fits better than the identified "
                "parameters: "
                f"{recorded.nominal_rms * 1e3:.2f} against {recorded.fitted_rms * 1e3:.2f} mm"
            )
    return lines


def _page(result: Identification, parameter_file: str) -> Iterator[str]:
    statistics = result.statistics
    yield f"# Parameters of rig '{result.config.rig.name}'"
    yield ""
    yield f"In the file `{parameter_file}`, to be included by a configuration."
    yield f"Fitted to: {fitted_to(result)}."
    yield f"Tendons' ends from: {'reports of the servos' if result.drive == 'measured' else 'commands'}."
    yield f"Scale of force from {result.scale}."
    yield ""
    yield "| parameter | unit | configuration | found | standard error | |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for found in result.parameters:
        parameter = found.parameter
        value = f"{found.value:.6g}" if found.found else "not found"
        error = ""
        if found.found:
            part = f" ({found.error / found.value:.2%})" if parameter.logarithmic else ""
            error = f"{found.error:.2g}{part}"
        yield f"| {parameter.name} | {parameter.unit} | {found.nominal:.6g} | {value} | {error} | {remark(found)} |"
    for ratio in result.ratios:
        share = f" ({ratio.error / ratio.value:.2%})" if ratio.value else ""
        yield f"| {ratio.name} | | {ratio.nominal:.6g} | {ratio.value:.6g} | {ratio.error:.2g}{share} | ratio |"
    yield ""
    if result.trials:
        yield "## Selection"
        yield ""
        yield "Change of the Bayesian information criterion by each candidate, and why it was not taken."
        yield ""
        yield "| candidate | change | taken | |"
        yield "| --- | --- | --- | --- |"
        for trial in result.trials:
            yield f"| {trial.name} | {change_of(trial)} | {'yes' if trial.taken else 'no'} | {trial.why} |"
        yield ""
    lines = warnings(result)
    if lines:
        yield "## Warnings"
        yield ""
        for line in lines:
            yield f"- {line}"
        yield ""
    if result.first.unidentifiable:
        yield "## Not identifiable from these data"
        yield ""
        for direction in result.first.unidentifiable:
            size = (
                "not visible in the data"
                if math.isinf(direction.deviation)
                else f"{direction.deviation:.1f} times too wide"
            )
            yield f"- {', '.join(direction.names)}: {size}"
        yield ""
    yield "## Model and measured tip"
    yield ""
    yield "Distance, root mean square and largest [mm]; a log that was not used tests the result."
    yield ""
    yield "| log | used | configuration | identified |"
    yield "| --- | --- | --- | --- |"
    for recorded in result.held_out:
        old = f"{recorded.nominal_rms * 1e3:.3f}, {recorded.nominal_max * 1e3:.2f}"
        new = f"{recorded.fitted_rms * 1e3:.3f}, {recorded.fitted_max * 1e3:.2f}"
        yield f"| {recorded.name} | {'yes' if recorded.used else 'no'} | {old} | {new} |"
    yield ""
    yield f"Residuals {result.rms * 1e3:.3f} mm a coordinate, noise of the poses {result.noise * 1e3:.3f} mm;"
    yield f"{statistics.samples} samples, equivalent to {statistics.effective:.0f} independent ones."
    yield ""
    yield "![Residuals](residuals.png)"
    yield "![Autocorrelation of the residuals](whiteness.png)"
    yield ""
    yield "## Correlation of the errors"
    yield ""
    names = [parameter.name for parameter in result.fit.parameters]
    yield f"| | {' | '.join(names)} |"
    yield f"|{' --- |' * (len(names) + 1)}"
    for name, row in zip(names, statistics.correlation, strict=True):
        yield f"| {name} | {' | '.join(f'{value:.2f}' for value in row)} |"


def numbers(result: Identification) -> dict[str, Any]:
    """Return all results for JSON; values that are not finite are None."""
    names = [parameter.name for parameter in result.fit.parameters]
    return {
        "rig": result.config.rig.name,
        "drive": result.drive,
        "statics": result.statics,
        "scale": result.scale,
        "parameters": {
            found.parameter.name: {
                "unit": found.parameter.unit,
                "configuration": found.nominal,
                "found": found.found,
                "value": found.value if found.found else None,
                "standard_error": found.error if found.found and math.isfinite(found.error) else None,
                "why": found.why,
                **({"decided_by": found.decided} if found.decided else {}),
            }
            for found in result.parameters
        },
        "selection": [
            {"name": one.name, "change": round(one.change, 2), "taken": one.taken, "why": one.why}
            for one in result.trials
        ],
        "ratios": {
            ratio.name: {"configuration": ratio.nominal, "value": ratio.value, "standard_error": ratio.error}
            for ratio in result.ratios
        },
        "correlation": {
            name: dict(zip(names, np.round(row, 4).tolist(), strict=True))
            for name, row in zip(names, result.statistics.correlation, strict=True)
        },
        "error_inflation": dict(zip(names, np.round(result.statistics.inflation, 3).tolist(), strict=True)),
        "unidentifiable": [
            {
                "names": list(direction.names),
                "times": direction.deviation if math.isfinite(direction.deviation) else None,
            }
            for direction in result.first.unidentifiable
        ],
        "residual_mm": result.rms * 1e3,
        "noise_mm": result.noise * 1e3,
        "evaluations": result.fit.evaluations,
        "logs": [
            {
                "name": recorded.name,
                "used": recorded.used,
                "configuration_rms_mm": recorded.nominal_rms * 1e3,
                "configuration_max_mm": recorded.nominal_max * 1e3,
                "identified_rms_mm": recorded.fitted_rms * 1e3,
                "identified_max_mm": recorded.fitted_max * 1e3,
            }
            for recorded in result.held_out
        ],
        "warnings": warnings(result),
    }


@dataclass(frozen=True)
class Written:
    """Files of an identification."""

    parameters: Path
    report: Path
    figures: tuple[Path, ...]


def write_results(result: Identification, out: Path, now: datetime, learned: Learned | None = None) -> Written:
    """Write parameter file, report, numbers and figures.

    Args:
        result: the identification.
        out: folder, created if missing.
        now: the date in the parameter file's name.
        learned: correction of what the fit leaves, if one was asked for.

    Raises:
        OSError: a file cannot be written.
    """
    from tendond.offline.identification.results.figure import draw

    out.mkdir(parents=True, exist_ok=True)
    path = free_name(out, now)
    write_whole(path, parameter_file(result, now, learned))
    page = report(result, path.name) + ("" if learned is None else f"\n## Learned correction\n\n{summary(learned)}\n")
    write_whole(out / "report.md", page)
    write_whole(out / "identified.json", json.dumps(numbers(result), indent=2, allow_nan=False) + "\n")
    return Written(path, out / "report.md", tuple(draw(result, out)))
