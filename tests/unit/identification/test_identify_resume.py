"""The fit's evaluations: an interrupted fit goes on, threads make no difference."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tendond.offline.identification.configured import nominal, starts
from tendond.offline.identification.fitting.evaluations import EvaluationCache
from tendond.offline.identification.fitting.problem import FitProblem
from tendond.offline.identification.fitting.solve import bounded_step
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameters import chosen
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.simulation.simulate import Simulation
from tests.unit.identification.recordings import CONFIG


def test_a_step_to_a_bound_is_the_best_one_there() -> None:
    random = np.random.default_rng(3)
    jacobian, residuals = random.standard_normal((40, 3)), random.standard_normal(40)
    jacobian[:, 1] += 3.0 * jacobian[:, 0]
    residuals += jacobian[:, 0]
    low, high = np.array([-0.01, -1.0, -1.0]), np.ones(3)
    best = lsq_linear(jacobian, -residuals, bounds=(low, high), tol=1e-14).x
    assert best[0] == pytest.approx(-0.01), "a bound is active"
    assert bounded_step(jacobian, residuals, low, high) == pytest.approx(best, abs=1e-6)


def test_an_interrupted_fit_goes_on_where_it_was_and_ends_at_the_same_bits(
    tmp_path: Path, free: Recording, weighted: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = Options(("E", "rho", "delay"))
    whole = identify([free, weighted], [], options, memory=tmp_path / "whole")
    assert not (tmp_path / "whole").exists()
    folder = tmp_path / "state"
    made: list[Any] = []
    honest = FitProblem.jacobian

    def counted(self: FitProblem, at: Any) -> Any:
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append(at)
        return honest(self, at)

    monkeypatch.setattr(FitProblem, "jacobian", counted)
    with pytest.raises(KeyboardInterrupt):
        identify([free, weighted], [], options, memory=folder)
    assert list(folder.rglob("jacobian-*.npy"))

    def noted(self: FitProblem, at: Any) -> Any:
        made.append(at)
        return honest(self, at)

    monkeypatch.setattr(FitProblem, "jacobian", noted)
    resumed = identify([free, weighted], [], options, memory=folder)
    assert resumed.fit.coordinates.tobytes() == whole.fit.coordinates.tobytes()
    assert len({at.tobytes() for at in made}) == len(made), "a derivative was computed twice"
    assert not folder.exists()


def test_another_fit_does_not_take_over_what_this_one_has_kept(tmp_path: Path) -> None:
    at = np.zeros(2)
    one, other = EvaluationCache(tmp_path, {"a": 1}), EvaluationCache(tmp_path, {"a": 2})
    one.get("residuals", at, lambda: np.ones(3))
    assert one.get("residuals", at, lambda: np.zeros(3)).tolist() == [1.0, 1.0, 1.0]
    assert other.get("residuals", at, lambda: np.zeros(3)).tolist() == [0.0, 0.0, 0.0]


def test_threads_and_their_number_make_no_difference(free: Recording) -> None:
    rows = [
        FitProblem(
            [Simulation(free, "measured")], chosen(("E", "delay")), starts(CONFIG, chosen(("E", "delay"))), None, jobs,
            lambda what, done, total: None,
        ).jacobian(np.zeros(2)).tobytes()
        for jobs in (1, 3)
    ]  # fmt: skip
    assert rows[0] == rows[1]


def test_derivatives_of_the_delay_are_those_of_its_definition(free: Recording) -> None:
    simulation, values = Simulation(free, "measured"), {**nominal(CONFIG), "delay": 0.012}
    motion = simulation.motion(values)
    step = (simulation.predicted_poses(motion, 0.013) - simulation.predicted_poses(motion, 0.011)) / 0.002
    speed = np.gradient(simulation.predicted_poses(motion, 0.012), 0.01, axis=0)
    assert np.abs(step + speed).max() < 0.1 * np.abs(speed).max()
