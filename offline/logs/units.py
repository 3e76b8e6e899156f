"""Units and components of what is in a log, by the names of its fields; SI."""

from collections.abc import Mapping

from tendond.schemas.config.sensors.section import SensorKind

UNITS = {
    "acceleration": "m/s^2",
    "altered": "N",
    "bend_error": "N m",
    "displacement": "m",
    "error": "m",
    "first_place": "m",
    "force": "N",
    "force_covariance": "N^2",
    "force_deviation": "N",
    "innovation": "m",
    "jog": "m/s",
    "last_place": "m",
    "lateness_us": "us",
    "measured": "m",
    "net_tension": "N",
    "offset": "m",
    "place": "m",
    "pose_lag": "s",
    "position": "m",
    "pull": "N",
    "reading_lags": "s",
    "residual": "N",
    "stamp_ns": "ns",
    "surface": "m/s",
    "tip_mass": "kg",
    "tip_mass_deviation": "kg",
    "target": "m",
    "tension": "N",
    "tension_deviation": "N",
    "tension_error": "N",
    "tension_estimate": "N",
    "time": "s",
    "tip_covariance": "m^2",
    "tip_force": "N",
    "tip_tension": "N",
    "velocity": "m/s",
    "wanted": "N",
    "work_us": "us",
    "z1": "m",
    "z2": "m/s",
}
"""Units by the last part of a field's name; all others are counts, texts, fractions, or mixed (`lyapunov`)."""

ROW_UNITS: dict[SensorKind, str] = {"markers": "m", "curvature": "1/m", "tension": "N"}
"""Units of a row of a sensor's reading, by its kind; the rows of the others are mixed."""

TENDONS = ("displacement", "tension", "tension_deviation", "tension_error", "tension_estimate", "tip_tension", "wanted")
"""Fields with a number per tendon."""


def unit_of(path: str, kinds: Mapping[str, SensorKind] | None = None) -> str:
    """Return the unit of a field such as `command.displacement`; empty where it has none.

    Args:
        path: of the field.
        kinds: of the sensors by name, for `inputs.readings.<name>.rows.<place>`.
    """
    match path.split("."):
        case ["inputs", "readings", name, "rows", _] if kinds and name in kinds:
            return ROW_UNITS.get(kinds[name], "")
        case ["inputs", "reading_lags", _]:
            return UNITS["reading_lags"]
    return "" if path == "model.error" else UNITS.get(path.rsplit(".", 1)[-1], "")


def components(path: str, count: int) -> list[str]:
    """Name the numbers of a field: by axes of a vector, orientation (w first) or covariance, else counted from 0."""
    name = path.rsplit(".", 1)[-1]
    if name == "orientation":
        return ["w", "x", "y", "z"]
    if name.endswith("covariance"):
        return ["xx", "xy", "xz", "yy", "yz", "zz"]
    if count == 3 and name not in TENDONS:
        return ["x", "y", "z"]
    return [str(i) for i in range(count)]


def column_name(path: str, component: str = "", unit: str | None = None) -> str:
    """Name a field's column in a table: `command_displacement_0_m`, `estimate_velocity_x_m_per_s`."""
    unit = (unit_of(path) if unit is None else unit).replace("^", "").replace("/", "_per_").replace(" ", "_")
    base = path.replace(".", "_")
    if component:
        base += f"_{component}"
    return f"{base}_{unit}" if unit and not base.endswith(f"_{unit}") else base
