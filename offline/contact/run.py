"""One seeded run: a robot unlike the model, the estimator, and a contact that comes and goes."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.estimation.contact.state import Contact
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import noise_of
from tendond.model.estimation.kalman.sensors import Markers
from tendond.model.rods.backbone import Backbone
from tendond.model.rods.general import GeneralRod
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.offline.contact.cases import (
    BEND,
    MARKERS,
    ORIENTATION,
    PAPER_UNIT,
    PERIOD,
    POSITION,
    Case,
    robot_of,
    tensions_of,
)

Array = NDArray[np.float64]

STEPS = 2
"""Steps of the robot in a cycle: a contact begins at any of them."""

ONSET, LASTING, AFTER = (2.5, 3.5), 1.0, 0.5
"""Range of the onset, time that a contact lasts, time after it [s]."""

LATER = (10, 40)
"""Cycles after the onset at which place and force are compared with the truth."""

BASE = 0.3
"""First place of a contact, as a part of the length."""


@dataclass(frozen=True)
class Sample:
    """What was known of a contact a while after its onset.

    Attributes:
        place: error [-], of the length. force: error of the vector [-], of the force; size: of its norm, likewise.
        covered: whether the interval has the place. width: of the interval [-], of the length.
    """

    place: float
    force: float
    size: float
    covered: bool
    width: float


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run.

    Attributes:
        case, seed: the run. place: of the contact [-], of the length; nan: there was none.
        found: time from its onset until it was found [s]; nan: it was not, while it lasted.
        samples: at `LATER`, none where it was not known then.
        released: time from its end until no contact was known [s]; nan: longer than `AFTER`, or it was not found.
        alarms: contacts that were known before the onset, when there was none; free: that time [s].
        tip: RMS error of the tip from the onset on [m].
    """

    case: Case
    seed: int
    place: float
    found: float
    samples: tuple[Sample | None, ...]
    released: float
    alarms: int
    free: float
    tip: float


class Setting:
    """Model and estimator of a case, for any number of runs."""

    def __init__(self, case: Case) -> None:
        self.case, self.robot = case, robot_of(case)
        self.model = GeneralRod(self.robot, PERIOD)
        parameters = self.model.parameters
        self.length = self.robot.length
        arms = np.array([float(np.hypot(*place)) for place in parameters.tendon_positions])
        self.largest: Array = BEND * parameters.bending_stiffness / (parameters.length * arms)
        self.unit = parameters.bending_stiffness / parameters.length**2
        noise = noise_of(parameters, POSITION, ORIENTATION, 0.1, 1.0, 0.1)
        self.markers = np.array(MARKERS) * self.length
        sensors = [Markers(self.markers, np.zeros(3), np.full(3 * len(MARKERS), POSITION))] if case.markers else []
        self.estimator = Estimator(self.model, noise, sensors, contacts=noise)

    def run(self, seed: int, cycles: int | None = None) -> Outcome:
        """Run once, from a seed; without a contact for so many cycles."""
        case, rng = self.case, np.random.default_rng(seed)
        place = BASE + (1.0 - BASE) * float(rng.uniform())
        friction = float(rng.uniform(*case.friction))
        tendons = tuple(replace(one, friction=friction) for one in self.robot.tendons)
        at = place * self.length
        robot = replace(self.robot, tendons=tendons)
        plant = StrainRod(robot, PERIOD / STEPS, stations=[at] if case.force else [])
        plant.layout.stiffness[:] *= 1.0 + float(rng.uniform(-case.stiffness, case.stiffness))
        body = Backbone(plant)
        onset = round(float(rng.uniform(*ONSET)) / PERIOD * STEPS)
        end = onset + round(LASTING / PERIOD * STEPS)
        count = (end // STEPS + round(AFTER / PERIOD)) if cycles is None else cycles
        pulls = tensions_of(case, rng, count, self.largest)
        angle, size = float(rng.uniform(0.0, 2.0 * np.pi)), case.force / PAPER_UNIT * self.unit
        truth, model = plant.solve_static(plant.loads()), self.model.solve_static(np.zeros(len(tendons)))
        estimate, force = self.estimator.start(model), np.zeros(3)
        known: list[Contact | None] = []
        error, forces = np.zeros(count), np.zeros((count, 3))
        for cycle in range(count):
            for step in range(cycle * STEPS, (cycle + 1) * STEPS):
                if case.force and step in (onset, end):
                    force = np.zeros(3) if step == end else size * self._across(plant, truth, at, angle)
                wrenches = [(at, force, np.zeros(3))] if case.force else []
                truth = plant.step(truth, plant.loads(tension=pulls[cycle], wrenches=wrenches))
            ahead = self.estimator.step(estimate, model, pulls[cycle])
            estimate, model = self.estimator.advance(estimate, model, ahead), ahead
            readings = self._readings(plant, body, truth, rng)
            estimate, model = self.estimator.correct(estimate, model, readings)
            known.append(estimate.contact)
            error[cycle], forces[cycle] = np.linalg.norm(plant.tip(truth)[0] - model.position), force
        if not case.force:
            return self._outcome(seed, known, error, count, count, forces, np.nan)
        return self._outcome(seed, known, error, onset // STEPS, end // STEPS, forces, place)

    @staticmethod
    def _across(plant: StrainRod, truth: StrainState, at: float, angle: float) -> Array:
        turn = plant.shape(truth).rotation[plant.node(at)[0]].reshape(3, 3)
        return np.asarray(turn @ np.array([np.cos(angle), np.sin(angle), 0.0]))

    def _readings(
        self, plant: StrainRod, body: Backbone, truth: StrainState, rng: np.random.Generator
    ) -> list[Reading]:
        position, rotation = plant.tip(truth)
        turned = Rotation.from_rotvec(rng.normal(0.0, ORIENTATION, 3)).as_matrix() @ rotation
        readings = [Reading(0, 0.0, position + rng.normal(0.0, POSITION, 3), turned)]
        if self.case.markers:
            points = body.frames(truth, self.markers)[0]
            readings.append(Reading(1, 0.0, (points + rng.normal(0.0, POSITION, points.shape)).reshape(-1)))
        return readings

    def _outcome(
        self, seed: int, known: list[Contact | None], error: Array, onset: int, end: int, forces: Array, place: float
    ) -> Outcome:
        alarms = sum(
            one is not None and before is None
            for before, one in zip([None, *known[: onset - 1]], known[:onset], strict=True)
        )
        during = [index for index in range(onset, end) if known[index] is not None]
        after = [index for index in range(end, len(known)) if known[index] is None]
        samples = tuple(
            self._sample(known[onset + later], forces[onset + later], place) if onset + later < end else None
            for later in LATER
        )
        found = bool(during)
        return Outcome(
            self.case, seed, place, (during[0] + 1 - onset) * PERIOD if found else np.nan, samples,
            (after[0] + 1 - end) * PERIOD if found and after else np.nan, alarms, onset * PERIOD,
            float(np.sqrt(np.mean(error[onset:] ** 2))) if onset < len(error) else float(np.sqrt(np.mean(error**2))),
        )  # fmt: skip

    def _sample(self, contact: Contact | None, force: Array, place: float) -> Sample | None:
        if contact is None:
            return None
        size, length = float(np.linalg.norm(force)), self.length
        return Sample(
            place=contact.place / length - place,
            force=float(np.linalg.norm(contact.force - force)) / size,
            size=float(np.linalg.norm(contact.force)) / size - 1.0,
            covered=contact.first <= place * length <= contact.last,
            width=(contact.last - contact.first) / length,
        )
