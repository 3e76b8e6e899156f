"""Names of fields of the state in snapshots of version 1, by class: a log of that version still replays."""

RENAMED: dict[str, dict[str, str]] = {
    "CycleState": {
        "since": "mode_since",
        "choice": "selection",
        "earlier": "previous_position",
        "interval": "pose_interval",
        "tension": "tension_estimate",
        "commanded": "tension_command",
        "wound": "displacement_estimate",
        "displacement": "displacement_command",
        "slip": "reference_offset",
        "way": "path_length",
        "lagging": "release_pending",
        "runs": "bad_cycles",
        "rest": "rest_watch",
        "age": "stamp_age",
        "jump": "jump_watch",
        "tracking": "tracking_watch",
    },
    "PoseAge": {"least": "lag_min", "run": "too_old"},
    "TrackingWatch": {
        "error_run": "error_cycles",
        "tip": "tip_swings",
        "tension": "tension_swings",
        "orientation_run": "orientation_cycles",
    },
    "JumpWatch": {
        "last": "last_step",
        "before": "origin",
        "size": "step_size",
        "lasting": "persistent",
        "over": "pose_distrusted",
        "gap": "gap_cycles",
    },
}
"""Old name to new name. What is not here has kept its name."""


def with_present_names(class_name: str, values: dict[str, object]) -> dict[str, object]:
    """Return the fields of a class under their present names."""
    names = RENAMED.get(class_name, {})
    return {names.get(name, name): value for name, value in values.items()}
