"""A mass on the paper's robot that the filter does not know: beside fixed gains, in the same loops."""

import pytest

from tendond.offline.estimator.loop.cases import Plant
from tendond.offline.estimator.loop.measure import run_loop

PLANT = Plant("20 g", mass=0.02, delay=1, circle=None, keys={"observer": {"tip_mass_error": 0.03}})


@pytest.mark.parametrize("law", ["backstepping", "sensitivity"])
def test_the_tip_is_nearer_to_its_reference_than_with_fixed_gains_and_does_not_swing(law: str) -> None:
    """A law that moves the tip within a cycle would whirl, were it given the inertia of that mass."""
    fixed, known = (run_loop(PLANT, law, kind, tracking=4.0) for kind in ("force", "kalman"))
    assert not known.reason
    assert known.motion < 0.9 * fixed.motion
    assert known.swing < 0.5e-3
