"""Baselines, learned correction, and figures of errors."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendond.cli.manual.evidence import renewed
from tendond.model.errors import ParameterError
from tendond.model.estimation.residual import Residual, residual_of
from tendond.offline.correction.learned import along, as_section, save, train
from tendond.offline.validation.baselines.polynomial import fit_polynomial
from tendond.offline.validation.results.metrics import by_tendon, errors_of
from tendond.offline.validation.results.repeatability import jumps, repeatability
from tendond.schemas.config.observer import ResidualSection

RNG = np.random.default_rng(3)
COMMAND = np.cumsum(RNG.uniform(-1.0, 1.0, (400, 3)), axis=0) * 1e-3
BLOCK = np.arange(400) // 20
TRAINING = BLOCK % 5 != 2


def quadratic(
    command: np.ndarray[tuple[int, int], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    a, b, c = command.T * 1e3
    return np.stack([a + 0.1 * a * b, b, 0.05 * c**2 - a], axis=1) * 1e-3


def test_a_polynomial_baseline_finds_a_polynomial() -> None:
    found = fit_polynomial(COMMAND, quadratic(COMMAND), BLOCK)
    assert found.degree >= 2
    assert errors_of(found.predict(COMMAND), quadratic(COMMAND)).rms < 1e-5


def trained() -> Residual:
    return train(COMMAND, quadratic(COMMAND), BLOCK, TRAINING)


def test_a_correction_learns_from_the_training_part_and_holds_on_the_other() -> None:
    found = trained()
    error = quadratic(COMMAND)[~TRAINING]
    left = np.linalg.norm(along(found, COMMAND)[~TRAINING] - error, axis=1)
    assert np.sqrt(np.mean(left**2)) < 0.3 * np.sqrt(np.mean(np.sum(error**2, axis=1)))
    spoilt = quadratic(COMMAND) + np.where(TRAINING[:, None], 0.0, 1.0)
    assert as_section(train(COMMAND, spoilt, BLOCK, TRAINING)) == as_section(found)


def test_a_correction_is_bounded_and_off_outside_of_its_data() -> None:
    found = trained()
    tight = replace(found, bound=1e-4)
    assert np.max(np.linalg.norm(along(tight, COMMAND), axis=1)) <= 1e-4 * (1.0 + 1e-12)
    low, high = np.array(found.low), np.array(found.high)
    outside = np.tile(high + 0.11 * (high - low), (3, 1))
    np.testing.assert_array_equal(along(found, outside), 0.0)
    half = np.tile(0.5 * (low + high), (3, 1))
    half[:, 0] = high[0] + 0.05 * (high[0] - low[0])
    inside = half.copy()
    inside[:, 0] = high[0]
    assert 0.0 < np.linalg.norm(along(found, half)[0]) < 0.8 * found.bound
    assert np.linalg.norm(along(found, inside)[0]) > 0.0


def test_a_saved_correction_gives_the_same_bits(tmp_path: Path) -> None:
    found = trained()
    save(found, tmp_path / "correction.json")
    section = ResidualSection.model_validate_json((tmp_path / "correction.json").read_text())
    np.testing.assert_array_equal(along(found, COMMAND), along(residual_of(section), COMMAND))
    others = section.model_copy(update={"features": ("1", "c7", *section.features[2:])})
    with pytest.raises(ParameterError, match="features are not those of"):
        residual_of(others)


def test_errors_are_those_of_distances() -> None:
    predicted = np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
    found = errors_of(predicted, np.zeros((2, 3)))
    assert found.rms == pytest.approx(np.sqrt(13.0))
    assert (found.largest, found.percentiles[0], found.count) == (5.0, 3.0, 2)
    split = by_tendon(predicted, np.zeros((2, 3)), np.array([[0.0, 1.0], [2.0, 1.0]]))
    assert [one.rms for one in split] == [1.0, 5.0]


def test_the_same_command_at_other_tips_is_what_no_function_of_it_can_know() -> None:
    command = np.repeat(np.linspace(0.0, 1.0, 50), 2)[:, None]
    command = np.vstack([command, command])  # twice, far apart in the sequence
    error = np.zeros((200, 3))
    error[100:, 0] = 2.0  # a model in between is 1 off everywhere
    found = repeatability(command, error - (1.0, 0.0, 0.0), near=1e-6, apart=50)
    assert found.rms == pytest.approx(np.sqrt(2.0))
    assert found.share == 1.0
    assert repeatability(command, error, near=1e-6, apart=500).pairs == 0


def test_a_jump_that_stays_is_found_and_a_single_outlier_is_not() -> None:
    command = np.zeros((100, 2))
    error = np.zeros((100, 3))
    error[60:, 1] = 5e-3
    error[30] = 0.1
    found = jumps(command, error, near=1e-4, size=2e-3)
    assert [one.pose for one in found] == [60]
    assert found[0].size == pytest.approx(5e-3)


def test_the_page_takes_each_report_up_to_its_second_heading() -> None:
    page = "a\n<!-- one -->\nold\n<!-- end -->\nb\n<!-- two -->\n<!-- end -->\n"
    made = renewed(page, {"one": "# one\n\nnew\n\n## By tendon\n\nmore\n"})
    assert made == "a\n<!-- one -->\n\nnew\n\n<!-- end -->\nb\n<!-- two -->\n<!-- end -->\n"
    with pytest.raises(ValueError, match="no place for three"):
        renewed(page, {"three": "# three\n\nnew\n"})
