"""The filter in the scene that viewers draw: the tip's ellipsoid, the force's arrow."""

import json
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from tendond.daemon.recording import scene
from tendond.daemon.recording.channels import ROD_SHAPE
from tendond.daemon.recording.entities import SceneUpdate
from tendond.offline.logs.run import open_run
from tendond.schemas.record import CycleRecord
from tendond.schemas.wire import encode
from tests.golden.scripts import FOLDER
from tests.unit.estimation.shown.conftest import Filtered
from tests.unit.offline.records import cycle_record

NORMAL = FOLDER / "normal.mcap"


def rotation(pose: dict[str, Any]) -> Rotation:
    return Rotation.from_quat([pose["orientation"][letter] for letter in "xyzw"])


def place(pose: dict[str, Any]) -> np.ndarray[Any, Any]:
    return np.array([pose["position"][letter] for letter in "xyz"])


@pytest.fixture(scope="module")
def drawn(filtered: Filtered) -> list[tuple[CycleRecord, dict[str, Any]]]:
    """Each record with a scene, and the filter's entity in it."""
    scenes = [json.loads(message.data)["entities"] for _, message in open_run(filtered.path).messages(("rod/shape",))]
    assert all([entity["id"] for entity in one] == ["rod", "trail", "filter"] for one in scenes)
    return list(zip(filtered.records[::5], [one[2] for one in scenes], strict=True))


def test_the_sphere_is_the_tips_ellipsoid(drawn: list[tuple[CycleRecord, dict[str, Any]]]) -> None:
    for record, entity in drawn:
        (sphere,) = entity["spheres"]
        assert record.observer.filter is not None
        xx, xy, xz, yy, yz, zz = record.observer.filter.tip_covariance
        turn = rotation(sphere["pose"]).as_matrix()
        half_axes = 0.5 * np.array([sphere["size"][letter] for letter in "xyz"])
        covariance = turn @ np.diag(half_axes**2) @ turn.T / chi2.ppf(0.95, 3)
        np.testing.assert_allclose(covariance, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], atol=1e-3 * (xx + yy + zz))
        np.testing.assert_array_equal(place(sphere["pose"]), record.model.position)


def test_the_arrow_is_the_force_and_the_cylinder_its_deviation(
    drawn: list[tuple[CycleRecord, dict[str, Any]]],
) -> None:
    pushed = [(record, entity) for record, entity in drawn if entity["arrows"]]
    assert len(pushed) > 10
    for record, entity in pushed:
        (arrow,), (cylinder,) = entity["arrows"], entity["cylinders"]
        scale = float(entity["metadata"][0]["value"])
        force = np.array(record.observer.force)
        length = arrow["shaft_length"] + arrow["head_length"]
        along = rotation(arrow["pose"]).apply([length, 0.0, 0.0])
        np.testing.assert_allclose(along, scale * force, atol=1e-12)
        np.testing.assert_array_equal(place(arrow["pose"]), record.model.position)
        np.testing.assert_allclose(place(cylinder["pose"]), np.array(record.model.position) + along, atol=1e-12)
        axis = rotation(cylinder["pose"]).apply([0.0, 0.0, 1.0])
        assert axis @ force == pytest.approx(np.linalg.norm(force))
        assert record.observer.filter is not None
        xx, xy, xz, yy, yz, zz = record.observer.filter.force_covariance
        variance = axis @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ axis
        assert cylinder["size"]["z"] == pytest.approx(2.0 * scale * np.sqrt(variance), rel=1e-6)


def test_no_force_has_no_arrow(filtered: Filtered) -> None:
    observer = filtered.records[0].observer.model_copy(update={"force": (0.0, 0.0, 0.0)})
    (entity,) = scene.filter_entities(0, (0.0, 0.0, 0.5), observer)
    assert (entity.arrows, entity.cylinders, len(entity.spheres)) == ((), (), 1)


def test_without_a_filter_a_scene_is_that_of_earlier_versions_to_the_byte() -> None:
    assert scene.filter_entities(0, (0.0, 0.0, 0.5), cycle_record(1).observer) == ()
    written = [message.data for _, message in open_run(NORMAL).messages((ROD_SHAPE.topic,))]
    assert len(written) > 5
    for data in written:
        assert encode(SceneUpdate.model_validate_json(data)) == data
