"""Extras of the package: which libraries they bring, and the line where one is missing."""

import importlib.util

EXTRAS = {
    "matplotlib": "plot",
    "plotly": "plot",
    "pyarrow": "parquet",
    "foxglove": "view",
    "ipykernel": "notebook",
    "pandas": "notebook",
    "dask": "cluster",
    "distributed": "cluster",
    "motioncapture": "vicon-sdk",
    "rosbags": "ros2",
    "mujoco": "mujoco",
    "gymnasium": "gym",
    "onnx": "onnx",
    "tornado": "dashboard",
    "cv2": "apriltag",
    "can": "can",
    "canopen": "can",
}
"""Extra by the import name of a library that it brings; the test compares them with pyproject.toml."""


def missing_line(module: str) -> str | None:
    """Return the line for a library that cannot be imported; none if it is of no extra."""
    library = module.partition(".")[0]
    extra = EXTRAS.get(library)
    return None if extra is None else f"this needs {library}, which is not installed: {install_command(extra)}"


def install_command(extra: str) -> str:
    """Return the command that installs an extra."""
    return f"pip install 'tendond[{extra}]'"


def need(module: str) -> None:
    """Refuse a long command at its start where the library that it ends with is missing.

    Raises:
        ModuleNotFoundError: it is not installed; the command line turns that into `missing_line`.
    """
    if importlib.util.find_spec(module) is None:
        raise ModuleNotFoundError(f"No module named '{module}'", name=module)
