"""Compilation of the kernels: without allocation, without the GIL, in SIMD lanes, and never out of date."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tendond.model.numerics import compile as compilation
from tendond.model.solver.march import march
from tendond.model.solver.timestep import advance, relax

COUNT_ALLOCATIONS = """
import json
import numba.core.runtime.nrt as nrt
from tendond.model import Rod, RodParameters

nrt._nrt.memsys_enable_stats()
counts = []
for nodes in (20, 200):
    rod = Rod(RodParameters(), "euler", nodes)
    state = rod.solve_static([1.0, 1.0, 1.0, 1.0])
    loads = rod.loads([5.0, 1.0, 1.0, 1.0])
    rod.advance(state, loads)
    before = nrt._nrt.memsys_get_stats_alloc()
    for _ in range(100):
        rod.advance(state, loads)
    counts.append((nrt._nrt.memsys_get_stats_alloc() - before) / 100)
print(json.dumps(counts))
"""


def test_a_step_allocates_nothing_but_the_handles_of_its_arguments() -> None:
    """numba wraps each array argument in a small handle; thirteen of them, whatever the nodes and iterations."""
    environment = {**os.environ, "NUMBA_NRT_STATS": "1"}
    result = subprocess.run(
        [sys.executable, "-c", COUNT_ALLOCATIONS], capture_output=True, text=True, check=True, env=environment
    )
    assert json.loads(result.stdout) == [13.0, 13.0]


@pytest.mark.parametrize("kernel", [advance, relax, march])
def test_the_kernels_release_the_gil(kernel: object) -> None:
    assert getattr(kernel, "targetoptions")["nogil"] is True  # noqa: B009 - numba's dispatchers are untyped


def test_a_changed_source_makes_every_kernel_out_of_date(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    model = Path(compilation.__file__).resolve().parents[1]
    for path in model.rglob("*.py"):
        copy = tmp_path / path.relative_to(model)
        copy.parent.mkdir(exist_ok=True)
        copy.write_bytes(path.read_bytes())
    monkeypatch.setattr(compilation, "__file__", str(tmp_path / "numerics" / "compile.py"))
    assert compilation.sources_digest() == compilation._SOURCES
    (tmp_path / "solver" / "march.py").write_text("# changed\n")
    assert compilation.sources_digest() != compilation._SOURCES
    assert advance._cache._cache_file._source_stamp == compilation._SOURCES
