"""Many environments at once, beside as many single ones in Gymnasium's own vector environment."""

import time
from typing import Any

import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from tendond.offline.learning.environment import TendonEnv
from tendond.offline.learning.vector import TendonVectorEnv
from tendond.schemas.config.rig import ConfigError, check_config

COUNT = 3
PLAIN: dict[str, Any] = {"solver": "general"}
RIG: dict[str, Any] = {
    **PLAIN,
    "servo": {"lag": 0.02, "friction": 0.05},
    "mocap": {"noise": 1e-3, "latency": 0.02, "dropout": 0.1, "rotation_noise": 0.01, "occlusion": 2.0},
    "impacts": [{"time": 0.58, "duration": 0.03, "force": [1.0, 2.0, 0.0]}],
}


def both(section: dict[str, Any], seconds: float, **more: Any) -> tuple[SyncVectorEnv, TendonVectorEnv]:
    config = check_config({"simulator": section}, "test")
    mode = more.get("autoreset_mode", AutoresetMode.NEXT_STEP)
    single = SyncVectorEnv([lambda: TendonEnv(config, seconds)] * COUNT, autoreset_mode=mode)
    return single, TendonVectorEnv(COUNT, config, seconds, **more)


def same(one: Any, other: Any) -> None:
    """Compare results of step or reset, nested, to the last bit."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            same(one[key], other[key])
    elif isinstance(one, tuple):
        for a, b in zip(one, other, strict=True):
            same(a, b)
    elif one is not None and one.dtype == object:
        for a, b in zip(one, other, strict=True):
            assert (a is None) == (b is None)
            same(a, b)
    elif one is not None:
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("section", "workers", "mode"),
    [(PLAIN, 1, AutoresetMode.NEXT_STEP), (RIG, 2, AutoresetMode.SAME_STEP)],
    ids=["ideal", "rig"],
)
def test_it_is_as_many_single_environments_to_the_last_bit(
    section: dict[str, Any], workers: int, mode: AutoresetMode
) -> None:
    """Over the ends of episodes, with other robots and goals in each, all that reset and step return."""
    single, many = both(section, 0.1, autoreset_mode=mode, workers=workers)
    assert many.observation_space == single.observation_space
    assert many.action_space == single.action_space
    assert many.metadata["autoreset_mode"] == single.metadata["autoreset_mode"]
    same(single.reset(seed=7), many.reset(seed=7))
    single.action_space.seed(1)
    ends = 0
    for _ in range(25):
        action = single.action_space.sample()
        found = many.step(action)
        same(single.step(action), found)
        ends += int(found[3].sum())
    assert ends == 2 * COUNT
    many.close()


def test_some_are_reset_while_the_others_go_on() -> None:
    single, many = both(PLAIN, 1.0)
    mask = np.array([True, False, True])
    for seed, options in ((3, None), ([11, None, None], {"reset_mask": mask, "goal": (0.1, 0.0, 0.45)})):
        given = [None if options is None else dict(options) for _ in range(2)]  # one takes its mask out
        same(single.reset(seed=seed, options=given[0]), many.reset(seed=seed, options=given[1]))
        for _ in range(5):
            action = np.full((COUNT, 4), 0.3)
            same(single.step(action), many.step(action))


def test_a_robot_without_a_solution_ends_its_episode_and_no_others() -> None:
    many, whole = TendonVectorEnv(COUNT, seconds=1.0), TendonVectorEnv(COUNT, seconds=1.0)
    for env in (many, whole):
        env.reset(seed=3)
    many._robots._batch.strain[1] = np.nan
    before = many._robots.tip[1].copy()
    action = np.full((COUNT, 4), 0.1)
    seen, reward, terminated, truncated, info = many.step(action)
    wanted = whole.step(action)
    assert terminated.tolist() == [False, True, False]
    assert not truncated.any()
    assert reward[1] == -1.0
    assert np.isnan(info["error"]).tolist() == [False, True, False]
    np.testing.assert_array_equal(seen[1, :3], before)
    for _ in range(3):
        np.testing.assert_array_equal(seen[[0, 2]], wanted[0][[0, 2]])
        seen, wanted = many.step(action)[0], whole.step(action)
        assert np.isfinite(seen).all()


def test_a_step_before_a_reset_is_refused() -> None:
    many = TendonVectorEnv(1, seconds=0.02, autoreset_mode=AutoresetMode.DISABLED)
    with pytest.raises(ResetNeeded):
        many.step(np.zeros((1, 4)))
    many.reset(seed=1)
    many.step(np.zeros((1, 4)))
    assert many.step(np.zeros((1, 4)))[3].all()
    with pytest.raises(ResetNeeded):
        many.step(np.zeros((1, 4)))


def test_a_robot_costs_a_fraction_of_its_own_environment() -> None:
    """Processor time for each robot and step; printed as a ratio, with `pytest -s`."""
    count, steps = 32, 60
    single, many = both(PLAIN, 2.0)[0].envs[0], TendonVectorEnv(count, randomise=False)
    used = []
    for env, shape, robots in ((single, (4,), 1), (many, (count, 4), count)):
        env.reset(seed=1)
        env.step(np.zeros(shape))
        started = time.process_time()
        for _ in range(steps):
            env.step(np.full(shape, 0.1))
        used.append((time.process_time() - started) / robots)
    print(f"{count} robots at once: each takes 1/{used[0] / used[1]:.0f} of the time of its own environment")
    assert used[1] < used[0] / 3.0


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"solver": "shooting"}, "simulator.solver = 'shooting': must be 'general'"),
        ({"weight": {"mass": 0.05}}, r"simulator\.weight: many at once carry none"),
        ({"impacts": [{"time": 1.0, "force": [1, 0, 0], "place": 0.5}]}, r"simulator\.impacts: must be at the tip"),
    ],
)
def test_what_a_batch_does_not_carry_is_refused_in_a_line(section: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match=rf"{words}.*SyncVectorEnv") as caught:
        TendonVectorEnv(2, check_config({"simulator": section}, "test"))
    assert "\n" not in str(caught.value)
