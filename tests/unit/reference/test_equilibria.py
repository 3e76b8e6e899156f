"""Targets with several equilibria: which is meant, what is refused, and that x is reached up to the fold."""

import numpy as np
import pytest

from tendond.daemon.control.reference.equilibria import default_branch
from tendond.daemon.control.reference.planar import PlanarReference, plan_in_plane
from tendond.daemon.errors import TargetError
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.rods.selection import model_rod
from tendond.offline.logs.run import _with_its_rules
from tendond.schemas.config.rig import parse_config
from tendond.schemas.requests import ControlAction


def plan(text: str) -> PlanarReference:
    config = parse_config(text, "test")
    return plan_in_plane(config, model_rod(config))


def test_a_number_selects_an_equilibrium_by_its_bend() -> None:
    first, second = (plan(f"[reference]\nacross = 0.34\nbranch = {k}") for k in (1, 2))
    assert first.arc is not None
    assert second.arc is not None
    assert first.arc == plan('[reference]\nacross = 0.34\nbranch = "below_135"').arc
    assert second.arc == plan("[reference]\nacross = 0.34").arc  # the paper's, of its robot
    assert first.notes == ()
    assert any("of 2 resting shapes" in note for note in second.notes)
    with pytest.raises(TargetError, match="give 1 to 2"):
        plan("[reference]\nacross = 0.34\nbranch = 3")


def test_other_robots_than_the_papers_rest_as_little_bent_as_they_can() -> None:
    text = "[rod]\nlength = 0.4\n[reference]\nacross = 0.27\n"
    assert plan(text).arc == plan(text + 'branch = "below_135"').arc
    assert plan(text + "[control]\nrules = 1").arc == plan(text + 'branch = "above_135"').arc
    assert default_branch(parse_config("", "test")) == "above_135"


ASKEW = "tendon_positions = [[0.0173, 0.01], [0.0, 0.02], [-0.02, 0.0], [0.0, -0.02]]"
"""Agonist at 30 degrees; four tendons, as the kernels of another number would have to be compiled."""


@pytest.mark.parametrize("rod", ["gravity = [0.0, -9.81, 0.0]", ASKEW])
def test_a_target_out_of_the_plane_is_refused_in_millimetres(rod: str) -> None:
    text = f"[rod]\n{rod}\n[reference]\nacross = 0.3\n"
    with pytest.raises(TargetError, match=r"\d+\.\d mm out of the plane 'xz', towards [+-]y"):
        plan(text)
    assert plan(text + 'unreachable = "track"').arc is not None
    assert plan(text + "[control]\nrules = 1").arc is not None  # logs from before still replay


@pytest.mark.parametrize("across", [0.3, 0.35])
def test_x_is_reached_where_the_tip_points_backwards_before_the_fold(across: float) -> None:
    text = f'[reference]\nacross = {across}\nbranch = "below_135"\nkind = "minimum_jerk"\n'
    config = parse_config(text, "test")
    *_, last = watched_loop(config, 600, {5: ControlAction.ARM})
    assert last.record.mode.value == "tracking"
    assert np.array(last.truth.position[0]) == pytest.approx(across, abs=1e-4)


def test_a_log_from_before_the_rules_had_a_number_keeps_its_own() -> None:
    assert _with_its_rules({"control": {"law": "backstepping"}})["control"]["rules"] == 1
    assert _with_its_rules({})["control"]["rules"] == 1
    assert _with_its_rules({"control": {"rules": 2}})["control"]["rules"] == 2
