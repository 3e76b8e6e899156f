"""A trained policy: a small network from the observation in space to the rates of the tensions.

With the layers' weights W and biases b, z the observation scaled by the robot,

    y = z,  y <- f(W y + b) for each layer, f its activation,  T + rate dt y, y within -1..1

so that a policy can ask for no more than `rate`, and that every limit of a command and the safety filter come after
it, as for any law. Its weights are parameters, so that a log has them and replays to the last bit; the command line
reads them from the file that `file` names. `offline/learning/environment.py` is where a policy is trained.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tendond.daemon.control.laws.law import Decision, LawParameters, LawTerms, SpatialObservation, StatelessLaw
from tendond.daemon.control.tasks.space import SPACE
from tendond.schemas.base import Vector3

Array = NDArray[np.float64]

KINEMATIC = 12
"""Numbers in the observation beside the tensions: position, velocity, target and its velocity, three each."""

WIDTH_MAX = 256
LAYERS_MAX = 4
"""Bounds of a policy's size: its time is then small beside that of the model's step."""

Row = Annotated[tuple[float, ...], Field(min_length=1, max_length=WIDTH_MAX)]


class Layer(LawParameters):
    """weights: W [-], a row an output. bias: b [-]. activation: of the outputs; 'relu' is max(0, y)."""

    weights: Annotated[tuple[Row, ...], Field(min_length=1, max_length=WIDTH_MAX)]
    bias: Row
    activation: Literal["tanh", "relu", "linear"] = "tanh"

    @model_validator(mode="after")
    def _fits(self) -> "Layer":
        if len(self.bias) != len(self.weights) or len({len(row) for row in self.weights}) != 1:
            raise ValueError("weights: must be rows of one length, as many as bias has numbers")
        return self


class Parameters(LawParameters):
    """file: of the policy, .npz or .onnx, beside the configuration; the command line reads it into the others.

    layers: of the network, the last one with an output a tendon. length: by which positions, and velocities of a
    second, are scaled [m]. tension: by which tensions are scaled [N]. rate: of a tension at an output of 1 [N/s].
    """

    file: str = ""
    layers: Annotated[tuple[Layer, ...], Field(max_length=LAYERS_MAX)] = ()
    length: Annotated[float, Field(gt=0.0, le=10.0)] = 1.0
    tension: Annotated[float, Field(gt=0.0, le=1e4)] = 1.0
    rate: Annotated[float, Field(gt=0.0, le=1e5)] = 100.0

    @model_validator(mode="after")
    def _chained(self) -> "Parameters":
        if not self.layers:
            raise ValueError("file: no policy: name the file of a trained one, see docs/howto/learn.md")
        sizes = [KINEMATIC + len(self.layers[-1].bias), *(len(layer.bias) for layer in self.layers)]
        for index, (layer, size) in enumerate(zip(self.layers, sizes, strict=False)):
            if len(layer.weights[0]) != size:
                raise ValueError(f"layers.{index}.weights: has rows of {len(layer.weights[0])} numbers, must be {size}")
        return self

    @cached_property
    def matrices(self) -> tuple[tuple[Array, Array], ...]:
        """Weights and bias of each layer, shapes (out, in) and (out,)."""
        return tuple((np.array(layer.weights), np.array(layer.bias)) for layer in self.layers)

    def act(self, observation: Array) -> Array:
        """Return the network's output [-], -1..1, shape (n,), for an observation in SI units, shape (12 + n,)."""
        scale = np.full(len(observation), self.length)
        scale[KINEMATIC:] = self.tension
        found: Array = observation / scale
        for layer, (weights, bias) in zip(self.layers, self.matrices, strict=True):
            found = weights @ found + bias
            if layer.activation == "tanh":
                found = np.tanh(found)
            elif layer.activation == "relu":
                found = np.maximum(found, 0.0)
        return np.asarray(np.clip(found, -1.0, 1.0))


@dataclass(frozen=True)
class Terms(LawTerms):
    """error: target less position [m]. output: of the network, for each tendon [-]."""

    error: Vector3
    output: tuple[float, ...]


def observed(position: Array, velocity: Array, target: Array, target_velocity: Array, tension: Array) -> Array:
    """Return a policy's observation, in this order, SI, shape (12 + n,)."""
    return np.concatenate((position, velocity, target, target_velocity, tension))


def decide(parameters: Parameters, observation: SpatialObservation) -> Decision:
    """Return the tensions wanted and the terms; a policy of another number of tendons holds them."""
    seen = observation
    x, y, z = (seen.target - seen.position).tolist()
    if len(parameters.layers[-1].bias) != len(seen.tension):
        return Decision(seen.tension, Terms((x, y, z), ()))
    output = parameters.act(observed(seen.position, seen.velocity, seen.target, seen.target_velocity, seen.tension))
    change = parameters.rate * seen.period * output
    return Decision(seen.tension + change, Terms((x, y, z), tuple(output.tolist())))


LAW = StatelessLaw("policy", Parameters, decide, SPACE)
