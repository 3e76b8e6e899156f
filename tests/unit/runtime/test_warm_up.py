"""No kernel is compiled, or even looked for on the disk, while the loop runs."""

import subprocess
import sys

import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.errors import TargetError
from tendond.daemon.runtime.warm_up import warm_up
from tendond.schemas.config.rig import check_config

FRESH = """
from tendond.daemon.control.cycle import step
from tendond.daemon.runtime.warm_up import warm_up as warm_up_cycle
from tendond.daemon.control.setup import CycleSetup
from tendond.model.numerics import compile as compiling
from tendond.model.numerics.rotation import quaternion
from tendond.model.warm import PARTS
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import TipPose
from tendond.schemas.requests import ControlAction
from tendond.schemas.record import CycleInputs

def loaded():
    return {kernel.py_func.__qualname__: len(kernel.signatures) for kernel in compiling._KERNELS}

"""


def run_fresh(code: str) -> str:
    """Start a process that has not used any kernel yet."""
    result = subprocess.run([sys.executable, "-c", FRESH + code], capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


BROUGHT = {
    "_find_correction", "_find_lack", "_line_search", "_slope", "accept_friction", "add_all_nodes",
    "add_all_points", "add_bend", "add_curvature", "add_friction", "add_friction_curvature",
    "add_friction_slopes", "add_node_rows", "add_point_rows", "add_products", "add_pulls", "add_spins",
    "add_tendon_stiffness", "add_transformed", "add_turn", "advance", "begin_friction", "begin_step",
    "curvature_of_points", "damped_step", "factor_lu", "factor_symmetric", "find_bends", "find_cells",
    "find_correction", "find_friction", "find_mass", "find_matrix", "find_momentum", "find_residual",
    "find_slopes", "find_spins", "march", "minimise", "move_tendon", "place_base", "project_rates",
    "pull_tendon", "solve", "solve_lu", "solve_lu_columns", "solve_rubbing", "solve_step", "solve_symmetric",
    "solve_back", "solve_symmetric_columns", "solve_three", "write_momenta", "write_node_momenta", "write_nodes",
    "write_points", "_add_product", "_copy", "_double", "_factor", "_project", "_solved", "_step", "_with_positive",
    "place_points", "smallest_change",
}  # fmt: skip
"""Called by other kernels alone, which bring them with them when they come from the disk."""


def test_setting_up_runs_every_kernel() -> None:
    code = "for part in PARTS.values():\n    part(4)\nprint(*(name for name, count in loaded().items() if not count))"
    assert set(run_fresh(code).split()) <= BROUGHT


BALL = {"obstacle": [{"kind": "sphere", "center": (0.12, 0.0, 0.46), "radius": 0.03}]}
"""On the way to the target: the filter alters commands there."""


@pytest.mark.parametrize("more", [{}, {"rod": {"preset": "nitinol"}}, {"safety": BALL}])
def test_after_warm_up_a_run_from_the_first_pose_to_tracking_loads_nothing_more(more: dict[str, object]) -> None:
    code = (
        f"config = check_config({{'reference': {{'across': 0.1}}, **{more}}}, 'test')"
        + """
setup = CycleSetup.from_config(config)
state = warm_up_cycle(setup)
before = loaded()
for seq in range(900):
    tip = setup.rod.tip(state.rod)
    pose = TipPose(
        seq=seq, stamp_ns=0, position=tuple(tip.position.tolist()), orientation=quaternion(tip.rotation)
    )
    request = ControlAction.ARM if seq == 5 else None
    state, _, record = step(setup, state, CycleInputs(pose=pose, request=request))
print(record.mode.value, {name: count for name, count in loaded().items() if count != before[name]})
"""
    )
    assert run_fresh(code) == "tracking {}"


def test_a_law_that_does_not_reach_the_target_keeps_no_other_from_starting() -> None:
    """All tendons at 1 N and more reach less far than the agonist alone, which the paper's laws pull."""
    rod = {
        "length": 0.25, "radius": 6e-4, "youngs_modulus": 60e9, "density": 6450.0, "damping_ratio": 0.02,
        "tip_mass": 0.015, "tendon_positions": [[0.008, 0.0], [-0.004, 0.007], [-0.004, -0.007]],
    }  # fmt: skip
    control, limits = {"law": "backstepping"}, {"tension_max": 5.7}
    setup = CycleSetup.from_config(
        check_config({"rod": rod, "control": control, "limits": limits, "reference": {"across": 0.08}}, "test")
    )
    with pytest.raises(TargetError, match="every tendon"):
        setup.selection.with_law(setup.config, setup.rod, "sensitivity")
    assert warm_up(setup).mode is initial_state(setup).mode
