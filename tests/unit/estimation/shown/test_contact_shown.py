"""A contact along the body in the scene, live and in the log, and in the status."""

import json
from typing import Any

import numpy as np
import pytest

from tendond.cli.watch.screen import frame, line
from tendond.daemon.recording import scene
from tendond.daemon.recording.contact_scene import CONTACT, contact_entity, no_contact
from tendond.offline.viewer.relay import LiveScene
from tendond.schemas.health import ContactHealth, FilterHealth
from tests.unit.cli.test_watch import CONFIG, beside_the_rod, status, watched

STRAIGHT = np.stack([np.zeros(50), np.zeros(50), np.linspace(0.0, 0.5, 50)], axis=1)
SIX = (1e-6, 0.0, 0.0, 1e-6, 0.0, 4e-6)


def test_a_contact_is_drawn_where_it_is_with_its_force() -> None:
    entity = contact_entity(0, STRAIGHT, 0.5, (0.3, 0.2, 0.4), (0.2, 0.0, 0.0), (0.02, 0.03, 0.0))
    (ball,), (line,), (arrow,), (band,) = entity.spheres, entity.lines, entity.arrows, entity.cylinders
    assert ball.pose.position.z == pytest.approx(0.3, abs=1e-4)
    assert (line.points[0].z, line.points[-1].z) == pytest.approx((0.2, 0.4), abs=1e-4)
    assert arrow.shaft_length + arrow.head_length == pytest.approx(0.2 * scene.FORCE_SCALE)
    assert arrow.pose.position.z == pytest.approx(0.3, abs=1e-4)
    assert band.size.z == pytest.approx(2.0 * scene.FORCE_SCALE * 0.02)
    gone = no_contact(0)
    assert gone.id == entity.id == CONTACT
    assert len(gone.spheres) + len(gone.lines) + len(gone.arrows) == 0


def test_words_say_force_and_place() -> None:
    found = ContactHealth(
        place=0.312, first_place=0.28, last_place=0.34, force=(0.0, 0.2, 0.0), force_deviation=(0.0, 0.03, 0.0)
    )
    assert found.in_words == "0.20±0.03 N at 312 mm (280 to 340)"


TOUCHED = FilterHealth(
    force=0.1, force_deviation=0.02, tip_bound=2e-3, stiffness=1.0, stiffness_deviation=0.01, consistency=1.0,
    contact=ContactHealth(
        place=0.25, first_place=0.2, last_place=0.3, force=(0.2, 0.0, 0.0), force_deviation=(0.02, 0.02, 0.0)
    ),
    force_vector=(0.0, 0.1, 0.0), tip_covariance=SIX, force_covariance=SIX,
)  # fmt: skip


class Kept:
    """Keeps the last message of each topic."""

    def __init__(self) -> None:
        self.messages: dict[str, Any] = {}

    def put(self, topic: str, data: bytes, time_ns: int) -> None:
        """Keep a message."""
        self.messages[topic] = json.loads(data)

    def entities(self) -> dict[str, Any]:
        """Entities of the last scene by their names."""
        return {one["id"]: one for one in self.messages["rod/shape"]["entities"]}


def test_the_live_scene_draws_ellipsoid_force_and_contact_and_takes_the_contact_away_again() -> None:
    kept = Kept()
    live = LiveScene(CONFIG, kept)
    live.draw(0)
    assert set(kept.entities()) == {"rod", "trail"}
    live.add(status().model_copy(update={"filter": TOUCHED}), 1)
    live.draw(1)
    drawn = kept.entities()
    assert drawn["filter"]["spheres"][0]["size"]["x"] == pytest.approx(2.0 * np.sqrt(7.815) * 1e-3)
    assert len(drawn["filter"]["arrows"]) == len(drawn["contact"]["arrows"]) == 1
    assert drawn["contact"]["spheres"][0]["pose"]["position"]["z"] == pytest.approx(0.25, abs=1e-3)
    live.add(status().model_copy(update={"filter": TOUCHED.model_copy(update={"contact": None})}), 2)
    live.draw(2)
    assert kept.entities()["contact"]["spheres"] == []


def test_the_terminal_shows_the_contact() -> None:
    snapshot = watched()
    snapshot.add(status().model_copy(update={"filter": TOUCHED, "tension_estimate": (1.0,) * 4}), 1.99)
    shown = frame(snapshot, CONFIG, 2.0, 80, 40).plain
    assert "contact 0.20±0.02 N at 250 mm (200 to 300)" in beside_the_rod(shown)
    assert "contact 0.20±0.02 N at 250 mm" in line(snapshot, CONFIG, 2.0)
