"""The Gymnasium environment, and the example that trains a policy."""

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tendond.model.errors import ConvergenceError
from tendond.offline.learning.environment import TendonEnv
from tendond.schemas.config.rig import ConfigError, check_config


@pytest.fixture(scope="module")
def env() -> TendonEnv:
    return TendonEnv(seconds=0.2)


def test_gymnasiums_own_checks_pass(env: TendonEnv) -> None:
    """Warnings are errors here, its advice too."""
    check_env(env, skip_render_check=True)


def test_the_same_seed_gives_the_same_episode_and_another_seed_another(env: TendonEnv) -> None:
    episodes = []
    for seed in (4, 4, 5):
        seen = [env.reset(seed=seed)[0]]
        seen += [env.step(np.array([1.0, 0.0, -1.0, 0.0]))[0] for _ in range(20)]
        episodes.append(np.array(seen))
    assert np.array_equal(episodes[0], episodes[1])
    assert not np.array_equal(episodes[0], episodes[2])


def test_an_action_is_a_rate_of_tension_within_the_limits(env: TendonEnv) -> None:
    config = env.config
    start, _ = env.reset(seed=1)
    one, *_ = env.step(np.array([1.0, -1.0, 0.0, 0.5]))
    rate = env.rate * config.loop.period
    assert one[12:] - start[12:] == pytest.approx([rate, 0.0, 0.0, 0.5 * rate])  # the second is at its least
    for _ in range(100):
        last, *_ = env.step(np.array([9.0, np.nan, 0.0, 0.0]))
    assert last[12:].max() == config.limits.tension_max


def test_pulling_the_right_tendon_pays(env: TendonEnv) -> None:
    """The goal is on +x, to which the first tendon bends."""
    returns = []
    for tendon in (0, 2):
        env.reset(seed=2, options={"goal": (0.15, 0.0, 0.46)})
        action = np.zeros(4)
        action[tendon] = 0.08
        returns.append(sum(env.step(action)[1] for _ in range(60)))
    assert returns[0] > returns[1] + 1.0


def test_robots_are_unlike_each_other_and_the_first_is_as_configured(env: TendonEnv) -> None:
    stiffness = [env.task.rig(number).simulator.rod.youngs_modulus for number in range(4)]
    assert stiffness[0] == env.config.rod.youngs_modulus
    assert len(set(stiffness)) == 4
    assert all(0.85 <= one / stiffness[0] <= 1.15 for one in stiffness)


def test_a_plant_without_a_solution_ends_the_episode(env: TendonEnv, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise ConvergenceError("no solution", 0.0, 1.0, 1)

    env.reset(seed=1)
    monkeypatch.setattr("tendond.drivers.simulator.plant.Plant.step", fails)
    _, reward, terminated, truncated, _ = env.step(np.zeros(4))
    assert (reward, terminated, truncated) == (-1.0, True, False)


def test_a_plant_that_displacement_drives_is_refused() -> None:
    config = check_config({"simulator": {"drive": "displacement"}, "rod": {"tendon_stiffness": 2e4},
                           "limits": {"slack": 0.002}}, "test")  # fmt: skip
    with pytest.raises(ConfigError, match="a policy acts on tensions"):
        TendonEnv(config)
