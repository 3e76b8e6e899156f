"""Policies from ONNX files: what the law computes beside ONNX's own evaluator, and what is refused."""

import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper
from onnx.reference import ReferenceEvaluator

from tendond.cli.common import load_config
from tendond.daemon.control.laws import select_law
from tendond.daemon.control.laws.policy import KINEMATIC, Parameters
from tendond.offline.learning.policy_file import read_policy
from tendond.schemas.config.rig import ConfigError
from tests.unit.logs.commands import run_command

TENDONS = 4
SIZE = KINEMATIC + TENDONS
Node = tuple[str, list[str], dict[str, Any]]

RANDOM = np.random.default_rng(5)
CONSTANTS = {
    "mean": RANDOM.normal(size=(1, SIZE)),
    "spread": RANDOM.uniform(0.5, 2.0, SIZE),
    "A": RANDOM.normal(0.0, 0.3, (8, SIZE)),
    "a": RANDOM.normal(size=8),
    "B": RANDOM.normal(0.0, 0.3, (8, 6)),
    "b": RANDOM.normal(size=6),
    "C": RANDOM.normal(0.0, 0.3, (6, TENDONS)),
    "c": RANDOM.normal(size=TENDONS),
    "two": np.array(2.0),
    "low": np.array(-1.0),
    "high": np.array(1.0),
}

CHAINS: dict[str, list[Node]] = {
    "as PyTorch exports a multilayer perceptron": [
        ("Gemm", ["x", "A", "a"], {"transB": 1}),
        ("Tanh", ["."], {}),
        ("Gemm", [".", "B", "b"], {"alpha": 0.5, "beta": 2.0}),
        ("Relu", ["."], {}),
        ("MatMul", [".", "C"], {}),
        ("Add", ["c", "."], {}),
        ("Clip", [".", "low", "high"], {}),
    ],
    "with a normalisation": [
        ("Sub", ["x", "mean"], {}),
        ("Div", [".", "spread"], {}),
        ("Cast", ["."], {"to": TensorProto.DOUBLE}),
        ("Gemm", [".", "A", "a"], {"transB": 1}),
        ("Relu", ["."], {}),
        ("MatMul", [".", "B"], {}),
        ("Sub", ["b", "."], {}),
        ("Flatten", ["."], {}),
        ("Gemm", [".", "C"], {}),
        ("Tanh", ["."], {}),
        ("Mul", ["two", "."], {}),
        ("Clip", [".", "low", "high"], {}),
    ],
}


def written(path: Path, nodes: list[Node], size: int = SIZE, **metadata: str) -> Path:
    """Write a chain; '.' is the output of the node before."""
    made = []
    for index, (kind, names, attributes) in enumerate(nodes):
        inputs = [f"y{index - 1}" if name == "." else name for name in names]
        made.append(helper.make_node(kind, inputs, [f"y{index}"], f"node{index}", **attributes))
    graph = helper.make_graph(
        made,
        "policy",
        [helper.make_tensor_value_info("x", TensorProto.DOUBLE, ["batch", size])],
        [helper.make_tensor_value_info(f"y{len(nodes) - 1}", TensorProto.DOUBLE, ["batch", TENDONS])],
        [numpy_helper.from_array(value, name) for name, value in CONSTANTS.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    helper.set_model_props(model, metadata)
    onnx.save(model, path)
    return path


@pytest.mark.parametrize("name", CHAINS)
def test_the_law_computes_what_onnx_does(name: str, tmp_path: Path) -> None:
    path = written(tmp_path / "p.onnx", CHAINS[name])
    parameters = Parameters.model_validate(read_policy(path))
    evaluate = ReferenceEvaluator(onnx.load(path))
    seen = RANDOM.normal(0.0, 2.0, (50, SIZE))
    results = evaluate.run(None, {"x": seen})
    assert isinstance(results, list)
    wanted = np.asarray(results[0], dtype=np.float64)
    found = np.array([parameters.act(one) for one in seen])
    assert found == pytest.approx(wanted, abs=1e-12)
    assert np.mean(np.abs(wanted) < 1.0) > 0.1  # or the comparison is of limits only
    assert np.std(wanted) > 0.1


def test_weights_in_a_file_of_their_own_are_read_and_missed(tmp_path: Path) -> None:
    path = written(tmp_path / "p.onnx", CHAINS["with a normalisation"])
    whole = read_policy(path)
    onnx.save(onnx.load(path), path, save_as_external_data=True, location="p.data", size_threshold=0)
    assert read_policy(path) == whole
    (tmp_path / "p.data").unlink()
    with pytest.raises(ConfigError, match=r"p\.onnx: .*weights"):
        read_policy(path)


def rig(tmp_path: Path, more: str = "") -> Path:
    path = tmp_path / "rig.toml"
    path.write_text(f'[control]\nlaw = "policy"\n[control.laws.policy]\nfile = "p.onnx"\n{more}')
    return path


def test_a_configuration_has_its_weights_and_the_rate_of_file_or_table(tmp_path: Path) -> None:
    written(tmp_path / "p.onnx", CHAINS["with a normalisation"])
    with pytest.raises(ConfigError, match=r"p\.onnx does not say the rate .*env\.rate"):
        load_config(rig(tmp_path))
    _, parameters = select_law("policy", load_config(rig(tmp_path, "rate = 90.0\n")).control.laws)
    assert isinstance(parameters, Parameters)
    assert parameters.rate == 90.0
    written(tmp_path / "p.onnx", CHAINS["with a normalisation"], rate="75", length="0.5")
    _, parameters = select_law("policy", load_config(rig(tmp_path)).control.laws)
    assert isinstance(parameters, Parameters)
    assert (parameters.rate, parameters.length, len(parameters.layers)) == (75.0, 0.5, 3)


REFUSED: dict[str, tuple[list[Node], str]] = {
    "another operator": ([("Sigmoid", ["x"], {})], "operator Sigmoid is not known"),
    "a branch": (
        [("Tanh", ["x"], {}), ("Relu", ["x"], {})],
        "operator Relu 'node1' is beside the chain",
    ),
    "a product with itself": ([("Mul", ["x", "x"], {})], "operator Mul 'node0' is beside the chain"),
    "a matrix of another size": ([("MatMul", ["x", "C"], {})], r"a matrix of shape \(4, 6\) for 16 inputs"),
    "a constant of another size": ([("Add", ["x", "a"], {})], r"a constant of shape \(8,\) beside 16"),
    "another Clip": ([("Clip", ["x", "low", "two"], {})], "operator Clip must be to -1..1"),
    "more after Clip": ([("Clip", ["x", "low", "high"], {}), ("Tanh", ["."], {})], "operator Tanh .* after Clip"),
    "a reciprocal": ([("Div", ["spread", "x"], {})], "operator Div is not known"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_chain_of_known_operators_is_refused_in_a_line(name: str, tmp_path: Path) -> None:
    nodes, words = REFUSED[name]
    with pytest.raises(ConfigError, match=rf"p\.onnx: {words}.*export the actor alone") as caught:
        read_policy(written(tmp_path / "p.onnx", nodes))
    assert "\n" not in str(caught.value)


def test_an_observation_of_another_or_no_fixed_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"last dimension of 9, must be 12 \+"):
        read_policy(written(tmp_path / "p.onnx", [("Tanh", ["x"], {})], 9))


@pytest.mark.parametrize("content", [b"", b"no model", b"\x08\x07"])
def test_a_file_that_is_no_onnx_is_refused_in_a_line(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "p.onnx").write_bytes(content)
    with pytest.raises(ConfigError, match=r"p\.onnx: .*export") as caught:
        load_config(rig(tmp_path))
    assert "\n" not in str(caught.value)
    with pytest.raises(ConfigError, match=r"other\.onnx: cannot be read: No such file"):
        read_policy(tmp_path / "other.onnx")


def test_a_file_far_beyond_any_policy_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "p.onnx").open("wb") as stream:
        stream.truncate(2**40)  # sparse: whoever reads it runs out of memory
    with pytest.raises(ConfigError, match=r"p\.onnx: \d+ bytes: a policy's file has 16777216 at most"):
        read_policy(tmp_path / "p.onnx")


def test_without_onnx_its_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(tmp_path / "p.onnx", CHAINS["with a normalisation"])
    monkeypatch.delitem(sys.modules, "tendond.offline.learning.onnx_file", raising=False)
    monkeypatch.setitem(sys.modules, "onnx", None)
    said = run_command("config", "check", str(rig(tmp_path)))
    assert said.returncode != 0
    assert re.search(r"pip install 'tendond\[onnx\]'", said.stderr), said.stderr
