"""The file of a policy: a NumPy archive of weights and scales, or an ONNX file; and its path into a configuration."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.laws.policy import Parameters
from tendond.schemas.config.rig import ConfigError, RigConfig

Array = NDArray[np.float64]

SCALES = ("length", "tension", "rate")


def save_policy(
    path: Path, layers: Sequence[tuple[Array, Array]], *, length: float, tension: float, rate: float
) -> None:
    """Write a policy.

    Args:
        path: file to write, .npz. layers: weights and bias of each, shapes (out, in) and (out,).
        length, tension, rate: scales, see `daemon.control.laws.policy.Parameters` [m, N, N/s].

    Raises:
        OSError: it cannot be written.
        ValidationError: no policy has these layers.
    """
    named = {f"{name}{index}": one for index, layer in enumerate(layers) for name, one in zip("Wb", layer, strict=True)}
    scales = {"length": length, "tension": tension, "rate": rate}
    Parameters.model_validate(_tables(named) | scales)
    with path.open("wb") as stream:
        np.savez(stream, allow_pickle=False, **named, **{name: np.array(one) for name, one in scales.items()})


def read_policy(path: Path) -> dict[str, Any]:
    """Return a policy's file as a table [control.laws.policy].

    Raises:
        ConfigError: it cannot be read, or is no policy.
        ModuleNotFoundError: an ONNX file, and onnx is not installed.
    """
    if path.suffix == ".onnx":
        from tendond.offline.learning.onnx_file import read_onnx  # an extra, which other files do not need

        return read_onnx(path)
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            arrays = {name: np.asarray(archive[name], dtype=np.float64) for name in archive.files}
        return _tables(arrays) | {name: float(arrays[name]) for name in SCALES}
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or 'is not a NumPy archive'}") from error
    except (BadZipFile, EOFError, KeyError, TypeError, ValueError, AttributeError) as error:
        wanted = f"W0, b0, W1, b1, ..., {', '.join(SCALES)}"
        raise ConfigError(f"{path}: is not a policy: must be a NumPy archive (.npz) with arrays {wanted}") from error


def with_policy(config: RigConfig, folder: Path, source: str) -> RigConfig:
    """Return the configuration with the policy whose file it names, if any, relative to a folder.

    Raises:
        ConfigError, ModuleNotFoundError: see `read_policy`; or the policy has another number of tendons, or no rate.
    """
    table = config.control.laws.get("policy", {})
    file = table.get("file")
    if not isinstance(file, str) or not file or "layers" in table:
        return config
    found = read_policy(folder / file) | table
    outputs, tendons = len(found["layers"][-1]["bias"]) if found["layers"] else 0, len(config.rod.tendon_positions)
    if outputs != tendons:
        raise ConfigError(
            f"{source}: control.laws.policy.file: {folder / file} has {outputs} outputs, but the robot has {tendons}"
            " tendons: train a policy for this robot"
        )
    if "rate" not in found:
        raise ConfigError(
            f"{source}: control.laws.policy.rate: {folder / file} does not say the rate of a tension at an output of 1:"
            " set it to that of the environment, `env.rate` [N/s]"
        )
    control = config.control.model_copy(update={"laws": {**config.control.laws, "policy": found}})
    return config.model_copy(update={"control": control})


def _tables(arrays: dict[str, Array]) -> dict[str, Any]:
    layers: list[dict[str, Any]] = []
    while f"W{len(layers)}" in arrays:
        index = len(layers)
        layers.append({"weights": arrays[f"W{index}"].tolist(), "bias": arrays[f"b{index}"].tolist()})
    return {"layers": layers}
