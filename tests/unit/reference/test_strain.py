"""The strain that a reference asks of the backbone: on both rods, in the plane, in space, and at a selection."""

import pytest

from tendond.daemon.control.reference.equilibria import rest_at
from tendond.daemon.control.reference.planar import PlanarReference
from tendond.daemon.control.reference.strain import bending_strain, yield_strain
from tendond.daemon.control.selection import Selection
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.runtime.planner import make_plan
from tendond.model.rods.selection import model_rod
from tendond.offline.equilibria_check import equilibria
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig, parse_config


def read(text: str) -> RigConfig:
    return parse_config(text, "rig.toml").with_own_rates()


@pytest.mark.parametrize("solver", ["shooting", "general"])
def test_the_strain_at_a_target_is_that_of_the_robots_figures(solver: str) -> None:
    config = read(f'[control]\nsolver = "{solver}"\n[reference]\nacross = 0.3\nbranch = 1\n')
    rod = model_rod(config)
    reference = Selection.from_config(config, rod).reference
    assert isinstance(reference, PlanarReference)
    assert reference.arc is not None
    strain = bending_strain(config.rod, rod, [rest_at(config, rod, reference.curve, reference.arc)])
    assert strain == pytest.approx(equilibria(config)[0].strain, rel=0.03)


SPACE = '[control]\nlaw = "sensitivity"\n[reference]\nkind = "circle"\nradius = 0.2\n'


@pytest.mark.parametrize("task", ["[reference]\nacross = 0.3\nbranch = 1\n", SPACE])
def test_a_reference_that_the_wire_does_not_bear_is_noted_and_one_that_it_bears_is_not(task: str) -> None:
    weak = read(f"[rod]\nyield_strain = 0.001\n{task}")
    strong = read(f"[rod]\nyield_strain = 0.02\n{task}")
    assert any("more than the 0.1 % that it bears by rod.yield_strain" in note for note in notes(weak))
    assert not any("strained" in note for note in notes(strong))


def notes(config: RigConfig) -> tuple[str, ...]:
    return Selection.from_config(config, model_rod(config)).reference.notes


def test_a_selection_at_run_time_is_noted_too() -> None:
    setup = CycleSetup.from_config(read("[rod]\nyield_strain = 0.006\n[reference]\nacross = 0.2\nbranch = 1\n"))
    assert setup.selection.reference.notes == ()
    plan = make_plan(setup, "backstepping", ReferenceSection(across=0.34, branch=2))
    assert plan.reference is not None
    folded, *_ = plan.reference.notes
    assert "of 2 resting shapes the folded one" in folded
    setup = CycleSetup.from_config(read("[rod]\nyield_strain = 0.005\n[reference]\nacross = 0.2\nbranch = 1\n"))
    plan = make_plan(setup, "backstepping", ReferenceSection(across=0.34, branch=2))
    assert plan.reference is not None
    assert any("more than the 0.5 % that it bears" in note for note in plan.reference.notes)


@pytest.mark.parametrize(
    ("modulus", "found"),
    [(206e9, (0.008, "spring steel")), (54e9, (0.06, "nitinol")), (3e9, (None, ""))],
)
def test_a_backbone_bears_what_its_modulus_says_unless_it_is_given(modulus: float, found: tuple[object, str]) -> None:
    assert yield_strain(read(f"[rod]\nyoungs_modulus = {modulus}\n").rod) == found
    assert yield_strain(read(f"[rod]\nyoungs_modulus = {modulus}\nyield_strain = 0.01\n").rod) == (0.01, "")
