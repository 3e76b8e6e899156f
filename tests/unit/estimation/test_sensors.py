"""What sensors are expected to read: against differences of the model's shape, and against the simulator's places."""

import numpy as np
import pytest

from tendond.model.estimation.kalman.sensors import Curvature, Imu, Markers, Sensor, Tension, TipPose
from tendond.model.estimation.kalman.taking import small_rotation
from tests.unit.estimation.robots import ROBOT, estimator_of, rod

PULLED = np.array([5.0, 0.5, 2.0, 1.0])
PLACES = np.array([0.12, 0.31, 0.5])
SENSORS: list[Sensor] = [
    TipPose(1e-4, 2e-3),
    Markers(PLACES, [[0.01, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.005]], np.full(9, 1e-4)),
    Curvature(PLACES, np.full(6, 0.01)),
    Imu(np.full(6, 0.1)),
]


@pytest.mark.parametrize("sensor", SENSORS, ids=lambda one: type(one).__name__)
def test_the_rows_are_the_derivatives_by_strains_and_rates(sensor: Sensor) -> None:
    """An imu's at rest: what the acceleration itself adds counts as noise. Markers' to what lies between nodes."""
    model = rod()
    errors = estimator_of(model).errors
    state = model.solve_static(PULLED)
    if not isinstance(sensor, Imu):
        state = model.step(model.step(state, 0.8 * PULLED), 0.8 * PULLED)
    expected = sensor.expect(model, errors, state)
    size, still = 1e-6, np.zeros(model.strain_rod.modes)
    for moved in ("strain", "rate"):
        rows = expected.rows[:, getattr(errors, moved)]
        for index, mode in enumerate(errors.kept):
            change = still.copy()
            change[mode] = size
            ends = []
            for sign in (1.0, -1.0):
                strain, rate = (sign * change, still) if moved == "strain" else (still, sign * change)
                ends.append(sensor.expect(model, errors, model.moved(state, strain, rate, 1.0)))
            column = (ends[0].value - ends[1].value) / (2.0 * size)
            if ends[0].rotation is not None and ends[1].rotation is not None:
                column = np.append(column, small_rotation(ends[0].rotation @ ends[1].rotation.T) / (2.0 * size))
            own = rows[: len(column), index]
            if isinstance(sensor, Imu) and moved == "rate":
                own, column = own[:3], column[:3]
            assert own == pytest.approx(column, abs=1e-2 * np.abs(expected.rows).max())


def test_a_load_cell_reads_the_tension_with_its_error() -> None:
    model = rod()
    errors = estimator_of(model).errors
    expected = Tension([2, 0], np.full(2, 0.1)).expect(model, errors, model.solve_static(PULLED))
    assert expected.value.tolist() == [2.0, 5.0]
    assert np.argmax(expected.rows, axis=1).tolist() == [errors.tension.start + 2, errors.tension.start]


def test_markers_at_nodes_are_where_the_backbone_is_and_gratings_read_a_constant_bend() -> None:
    model = rod()
    errors = estimator_of(model).errors
    state = model.solve_static(PULLED)
    nodes = model.backbone.nodes[1:]
    seen = Markers(nodes, np.zeros(3), np.ones(3 * len(nodes))).expect(model, errors, state).value
    assert seen.reshape(-1, 3) == pytest.approx(model.strain_rod.backbone(state.strain)[1:], abs=1e-12)
    bent = np.zeros(model.strain_rod.modes)
    bent[0] = 1.5
    straight = model.solve_static(np.zeros(len(ROBOT.tendons)))
    moved = model.moved(straight, bent - straight.strain.strain, 0.0 * bent, 1.0)
    assert Curvature(PLACES, np.ones(6)).expect(model, errors, moved).value == pytest.approx([1.5, 0.0] * 3)
