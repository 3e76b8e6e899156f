"""Units and components of what is in a log, by the names of its fields; SI."""

UNITS = {
    "acceleration": "m/s^2",
    "displacement": "m",
    "error": "m",
    "force": "N",
    "innovation": "m",
    "lateness_us": "us",
    "measured": "m",
    "net_tension": "N",
    "offset": "m",
    "pose_lag": "s",
    "position": "m",
    "pull": "N",
    "residual": "N",
    "stamp_ns": "ns",
    "surface": "m/s",
    "target": "m",
    "tension": "N",
    "tension_estimate": "N",
    "time": "s",
    "tip_force": "N",
    "velocity": "m/s",
    "wanted": "N",
    "work_us": "us",
    "z1": "m",
    "z2": "m/s",
}
"""Units by the last part of a field's name; all others are counts, texts, fractions, or mixed (`lyapunov`)."""

TENDONS = ("displacement", "tension", "tension_estimate", "wanted")
"""Fields with a number per tendon."""


def unit_of(path: str) -> str:
    """Return the unit of a field such as `command.displacement`; empty where it has none."""
    return "" if path == "model.error" else UNITS.get(path.rsplit(".", 1)[-1], "")


def components(path: str, count: int) -> list[str]:
    """Name the numbers of a field: x, y, z of a vector, w, x, y, z of an orientation, else counted from 0."""
    name = path.rsplit(".", 1)[-1]
    if name == "orientation":
        return ["w", "x", "y", "z"]
    if count == 3 and name not in TENDONS:
        return ["x", "y", "z"]
    return [str(i) for i in range(count)]


def column_name(path: str, component: str = "") -> str:
    """Name a field's column in a table: `command_displacement_0_m`, `estimate_velocity_x_m_per_s`."""
    unit = unit_of(path).replace("^", "").replace("/", "_per_")
    base = path.replace(".", "_")
    if component:
        base += f"_{component}"
    return f"{base}_{unit}" if unit and not base.endswith(f"_{unit}") else base
