"""A slender arm that swings with more on its tip than configured: the smoother finds the mass, and no forces."""

import numpy as np

from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.smoothing.passes import smooth_stretch
from tendond.offline.smoothing.smooth import estimator_of
from tendond.offline.smoothing.stretches import stretches
from tendond.schemas.requests import ControlAction
from tests.unit.pose.test_slender_arm import UNLIKE, rig

MORE = 0.005


def test_a_mass_that_swings_is_found_and_leaves_no_force_on_the_tip() -> None:
    plant = {"weight": {"mass": MORE}, **UNLIKE[0]}
    config = rig(plant, observer=UNLIKE[1])
    records = [one.record for one in watched_loop(config, 150, {30: ControlAction.ARM})]
    largest = []
    for error in (MORE, 0.0):
        given = rig(plant, observer={"kind": "kalman", **UNLIKE[1], "tip_mass_error": error})
        (stretch,) = stretches(given, records)
        found = smooth_stretch(estimator_of(given, "run"), stretch)
        errors = found.model.estimator.errors
        largest.append(float(np.linalg.norm(found.path.errors[:, errors.force], axis=1).max()))
        if error:
            assert abs(found.path.errors[-1, -1] - MORE) < 0.1 * MORE
    assert largest[0] < 0.3 * largest[1]
