"""A policy as an ONNX file: operators folded into the layers of the law `policy`, so that the loop needs no runtime.

Understood is a chain from one input, the observation of `offline/learning/environment.py` in SI units, to one output:
Gemm and MatMul by constants; Add, Sub, Mul and Div by constants, as of a normalisation; Tanh and Relu; Clip to -1..1 at
its end; and Identity, Flatten, Cast, Constant and Transpose, which compute nothing. Semantics are those of the
operators' specification, https://onnx.ai/onnx/operators/.
"""

from pathlib import Path
from typing import Any

import numpy as np
import onnx
from google.protobuf.message import DecodeError
from numpy.typing import NDArray
from onnx import NodeProto, helper, numpy_helper

from tendond.daemon.control.laws.policy import KINEMATIC, WIDTH_MAX
from tendond.schemas.config.rig import ConfigError

Array = NDArray[np.float64]

SIZE_MAX = 16 * 2**20
"""Largest file that is read [bytes]: four layers of the largest width, with room for names, are below 3 MB."""

OPERATORS = "Gemm, MatMul, Add, Sub, Mul, Div, Tanh, Relu, Clip"
ACTIVATIONS = {"Tanh": "tanh", "Relu": "relu"}
PASSED = ("Identity", "Flatten", "Cast", "Dropout")
"""Operators that leave a row of numbers as it is; Dropout does where nothing is trained."""

METADATA = ("length", "tension", "rate")
"""Keys of the file's metadata that are parameters of the law; lengths and tensions are in SI without them."""


def read_onnx(path: Path) -> dict[str, Any]:
    """Return a policy's ONNX file as a table [control.laws.policy]; without `rate` where the file does not say it.

    Raises:
        ConfigError: it cannot be read, or is not a chain of the operators above.
        ModuleNotFoundError: onnx is not installed.
    """
    try:
        if path.stat().st_size > SIZE_MAX:
            raise ConfigError(f"{path}: {path.stat().st_size} bytes: a policy's file has {SIZE_MAX} at most")
        model = onnx.load(path)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror or 'its weights are not beside it'}") from error
    except (DecodeError, onnx.checker.ValidationError) as error:  # the second one: weights in a file that is not there
        raise ConfigError(f"{path}: is not a policy: must be an ONNX file with its weights: export it again") from error
    try:
        chain = _Chain(model.graph)
        scales = {one.key: float(one.value) for one in model.metadata_props if one.key in METADATA}
    except (ValueError, TypeError, IndexError, OverflowError) as error:
        reason = str(error).splitlines()[0] if str(error) else "is malformed"
        raise ConfigError(f"{path}: {reason}: a policy is one chain of {OPERATORS}: export the actor alone") from error
    return {"layers": chain.layers} | scales


class _Chain:
    """The layers of a graph.

    Attributes:
        layers: as `Layer` of the law has them.

    Raises:
        ValueError: it is not a chain of known operators.
    """

    def __init__(self, graph: onnx.GraphProto) -> None:
        self._constants: dict[str, Array] = {one.name: _array(one) for one in graph.initializer}
        inputs = [one for one in graph.input if one.name not in self._constants]
        if len(inputs) != 1 or len(graph.output) != 1:
            raise ValueError(f"has {len(inputs)} inputs and {len(graph.output)} outputs, must have one of each")
        size = inputs[0].type.tensor_type.shape.dim[-1].dim_value
        if not KINEMATIC < size <= KINEMATIC + WIDTH_MAX:
            raise ValueError(f"its input has a last dimension of {size}, must be {KINEMATIC} + the number of tendons")
        self.layers: list[dict[str, Any]] = []
        self._fresh(size)
        self._at, self._clipped = inputs[0].name, False
        for node in graph.node:
            self._take(node)
        if self._at != graph.output[0].name:
            raise ValueError(f"its output '{graph.output[0].name}' is not the end of a chain")
        if self._changed:
            self._close("linear")

    def _fresh(self, size: int) -> None:
        """Begin a layer: y = W x + b with W = 1, b = 0, into which operators are folded up to the next activation."""
        self._weights, self._bias, self._changed = np.eye(size), np.zeros(size), False

    def _close(self, activation: str) -> None:
        self.layers.append(
            {"weights": self._weights.tolist(), "bias": self._bias.tolist(), "activation": activation}
        )  # fmt: skip
        self._fresh(len(self._bias))

    def _take(self, node: NodeProto) -> None:
        attributes = {one.name: helper.get_attribute_value(one) for one in node.attribute}
        kind, names = node.op_type, [name for name in node.input if name]
        if kind == "Constant":
            self._constants[node.output[0]] = _constant(attributes)
            return
        given = [self._constants.get(name) for name in names]
        if kind in ("Identity", "Cast", "Transpose") and given[0] is not None:
            self._constants[node.output[0]] = given[0].T if kind == "Transpose" else given[0]
            return
        if names.count(self._at) != 1 or sum(one is None for one in given) != 1:
            raise ValueError(f"operator {kind} '{node.name}' is beside the chain")
        if self._clipped:
            raise ValueError(f"operator {kind} '{node.name}' comes after Clip")
        self._fold(kind, attributes, given, names.index(self._at))
        self._at = node.output[0]

    def _fold(self, kind: str, attributes: dict[str, Any], given: list[Array | None], place: int) -> None:
        others = [one for one in given if one is not None]
        if kind in ACTIVATIONS:
            self._close(ACTIVATIONS[kind])
        elif kind == "Gemm" and place == 0 and not attributes.get("transA", 0):
            matrix = others[0] if attributes.get("transB", 0) else others[0].T
            self._multiply(attributes.get("alpha", 1.0) * matrix)
            if len(others) > 1:
                self._bias = self._bias + attributes.get("beta", 1.0) * self._row(others[1])
        elif kind == "MatMul" and place == 0:
            self._multiply(others[0].T)
        elif kind in ("Add", "Sub", "Mul") or (kind == "Div" and place == 0):
            self._elementwise(kind, self._row(others[0]), place)
        elif kind == "Clip":
            low, high = others if len(others) == 2 else (attributes.get("min"), attributes.get("max"))
            if low is None or high is None or np.any(low != np.array(-1.0)) or np.any(high != np.array(1.0)):
                raise ValueError("operator Clip must be to -1..1")
            self._clipped = True  # the law clips its outputs to the same
        elif kind not in PASSED:
            raise ValueError(f"operator {kind} is not known here")

    def _multiply(self, matrix: Array) -> None:
        """Fold a matrix in, shape (out, in)."""
        if matrix.ndim != 2 or matrix.shape[1] != len(self._bias) or len(matrix) > WIDTH_MAX:
            raise ValueError(f"a matrix of shape {matrix.shape} for {len(self._bias)} inputs, at most {WIDTH_MAX} rows")
        self._weights, self._bias = matrix @ self._weights, matrix @ self._bias
        self._changed = True

    def _elementwise(self, kind: str, row: Array, place: int) -> None:
        if kind in ("Mul", "Div"):
            factor = 1.0 / row if kind == "Div" else row
            self._weights, self._bias = factor[:, None] * self._weights, factor * self._bias
        elif kind == "Add":
            self._bias = self._bias + row
        elif place == 0:
            self._bias = self._bias - row
        else:  # a constant less the row
            self._weights, self._bias = -self._weights, row - self._bias
        self._changed = True

    def _row(self, constant: Array) -> Array:
        """Return a constant as a number for each of the row, which it must not widen."""
        if constant.size not in (1, len(self._bias)):
            raise ValueError(f"a constant of shape {constant.shape} beside {len(self._bias)} numbers")
        return np.broadcast_to(constant.reshape(-1), self._bias.shape)


def _array(tensor: onnx.TensorProto) -> Array:
    return np.asarray(numpy_helper.to_array(tensor), dtype=np.float64)


def _constant(attributes: dict[str, Any]) -> Array:
    """Return the value of an operator Constant, which has one attribute of several names."""
    (value,) = attributes.values()
    return _array(value) if isinstance(value, onnx.TensorProto) else np.asarray(value, dtype=np.float64)
