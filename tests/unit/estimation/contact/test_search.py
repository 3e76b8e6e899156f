"""The search for contacts with the estimator, on a robot that is its model and on one that is not."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.model.estimation.contact.state import Contact
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import noise_of
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.stations import BodyLoads
from tests.unit.strain.robots import paper, rubbing

Array = NDArray[np.float64]

ONSET, END, CYCLES = 150, 220, 260
POSITION, ORIENTATION = 1e-4, 2e-3


class Arm:
    """The estimator on the paper's robot, and a true robot beside it that is touched at one of the model's stations."""

    def __init__(self, friction: float = 0.0, age: int = 0, contacts: bool = True) -> None:
        self.model, self.truth = GeneralRod(paper(), 0.01), GeneralRod(rubbing(paper(), friction), 0.01)
        noise = noise_of(self.model.parameters, POSITION, ORIENTATION, 0.1, 1.0, 0.1)
        self.estimator = Estimator(self.model, noise, age_max=0.01 * age, contacts=noise if contacts else None)
        self.no_moments = np.zeros((len(self.truth.backbone.nodes), 3))
        self.age, self.tip_error = age, 0.0

    def run(self, station: int, force: Array, pulls: Array, seed: int = 0) -> list[Contact | None]:
        """Run for so many cycles as there are tensions; the force acts from `ONSET` to `END`."""
        rng = np.random.default_rng(seed)
        truth, model = self.truth.solve_static(pulls[0]), self.model.solve_static(pulls[0])
        estimate, known, past, errors = self.estimator.start(model), [], [truth], []
        forces = np.zeros((len(self.model.stations.at), 3))
        for cycle, pull in enumerate(pulls):
            forces[station] = force if ONSET <= cycle < END else 0.0
            truth = self.truth.step_bent(truth, pull, np.zeros(3), BodyLoads(self.no_moments, forces.copy()))
            past.append(truth)
            ahead = self.estimator.step(estimate, model, pull)
            estimate, model = self.estimator.advance(estimate, model, ahead), ahead
            readings = [self._reading(past[max(0, len(past) - 1 - self.age)], rng)]
            estimate, model = self.estimator.correct(estimate, model, readings)
            known.append(estimate.contact)
            errors.append(float(np.linalg.norm(truth.position - model.position)))
        self.estimate, self.tip_error = estimate, float(np.sqrt(np.mean(np.square(errors[ONSET:]))))
        return known

    def _reading(self, state: GeneralState, rng: np.random.Generator) -> Reading:
        position, rotation = self.truth.strain_rod.tip(state.strain)
        turned = Rotation.from_rotvec(rng.normal(0.0, ORIENTATION, 3)).as_matrix() @ rotation
        return Reading(0, 0.01 * self.age, position + rng.normal(0.0, POSITION, 3), turned)


def resting(cycles: int = CYCLES) -> Array:
    return np.tile([2.0, 1.0, 0.5, 1.0], (cycles, 1))


def moving(cycles: int) -> Array:
    time = 0.01 * np.arange(cycles)[:, None]
    return np.asarray(2.0 + 2.0 * np.sin(time * np.array([2.0, 3.1, 2.7, 1.7]) + np.arange(4)))


def first_of(known: list[Contact | None]) -> int:
    return next(cycle for cycle, one in enumerate(known) if one is not None)


@pytest.mark.parametrize("station", [4, 5, 7])
@pytest.mark.parametrize("age", [0, 2])
def test_a_contact_is_found_located_sized_and_its_end_seen(station: int, age: int) -> None:
    arm, force = Arm(age=age), np.array([0.0, 0.2, 0.0])
    known = arm.run(station, force, resting())
    contact = known[ONSET + 40]
    length, place = arm.model.robot.length, arm.model.stations.at[station]
    assert ONSET <= first_of(known) < ONSET + 10
    assert contact is not None
    assert contact.place == pytest.approx(place, abs=0.05 * length)
    assert contact.first <= place <= contact.last
    assert contact.tip is bool(contact.last >= length)
    assert contact.force == pytest.approx(force, abs=0.2 * 0.2)
    assert contact.onset == pytest.approx(ONSET, abs=1.0)
    assert contact.settled
    assert all(one is None for one in known[END + 10 :])


def test_the_tip_is_followed_as_well_as_without_the_search() -> None:
    touched, plain = Arm(), Arm(contacts=False)
    touched.run(4, np.array([0.0, 0.2, 0.0]), resting())
    plain.run(4, np.array([0.0, 0.2, 0.0]), resting())
    assert touched.tip_error < plain.tip_error


def test_the_model_takes_the_force_where_it_acts() -> None:
    arm, force = Arm(), np.array([0.0, 0.2, 0.0])
    arm.run(4, force, resting(END))
    assert arm.estimate.contacts is not None
    acting = arm.estimate.contacts.forces
    assert acting.sum(axis=0) == pytest.approx(force, abs=0.2 * 0.2)
    assert np.linalg.norm(acting[[3, 4, 5]].sum(axis=0)) == pytest.approx(np.linalg.norm(acting.sum(axis=0)))
    assert np.linalg.norm(arm.estimate.force) < 0.1 * 0.2


def test_nothing_is_found_where_nothing_is() -> None:
    for friction in (0.0, 0.2):
        assert all(one is None for one in Arm(friction).run(7, np.zeros(3), moving(1500), seed=3))


def test_a_contact_is_found_in_motion_with_friction_that_the_model_does_not_know() -> None:
    arm = Arm(friction=0.15)
    known = arm.run(6, np.array([0.0, 0.3, 0.0]), moving(CYCLES))
    contact = known[ONSET + 40]
    assert first_of(known) in range(ONSET, ONSET + 10)
    assert contact is not None
    assert contact.place == pytest.approx(arm.model.stations.at[6], abs=0.1 * arm.model.robot.length)


def test_the_state_comes_back_from_its_text_while_a_contact_is_weighed() -> None:
    arm = Arm()
    arm.run(5, np.array([0.0, 0.2, 0.0]), resting(ONSET + 12))
    assert arm.estimate.contact is not None
    assert not arm.estimate.contact.settled
    again = decode_state(EstimatorState, encode_state(arm.estimate))
    assert encode_state(again) == encode_state(arm.estimate)
    assert again.contact is not None
    assert again.contact.place == arm.estimate.contact.place
