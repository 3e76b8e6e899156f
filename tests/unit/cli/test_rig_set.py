"""`tendond set`: short keys, and the remark on gains that make the loop unstable."""

import pytest

from tendond.cli.rig.tuning import full_key, loop_remark
from tendond.daemon.control.tuning.keys import tunable_keys
from tendond.daemon.errors import UsageError
from tendond.schemas.config.rig import RigConfig, check_config

KEYS = list(tunable_keys(RigConfig().with_own_rates()))


@pytest.mark.parametrize(
    ("short", "law", "key"),
    [
        ("alpha1", "backstepping", "control.laws.backstepping.alpha1"),
        ("alpha1", "mpc", "control.laws.backstepping.alpha1"),
        ("rate", "mpc", "control.laws.mpc.rate"),
        ("sensitivity.rate", "mpc", "control.laws.sensitivity.rate"),
        ("tension_max", "mpc", "limits.tension_max"),
        ("limits.slack", "mpc", "limits.slack"),
        ("ension_max", "mpc", "ension_max"),
    ],
)
def test_a_key_may_be_shortened_and_that_of_the_law_in_use_comes_first(short: str, law: str, key: str) -> None:
    assert full_key(short, KEYS, law) == key


def test_a_short_key_that_stands_for_several_is_refused() -> None:
    with pytest.raises(UsageError, match=r"rate: may be control\.laws\.sensitivity\.rate or control\.laws\.mpc\.rate"):
        full_key("rate", KEYS, "backstepping")


def test_gains_that_make_the_loop_unstable_are_remarked_upon_with_the_growth_of_motions() -> None:
    wild = check_config({"control": {"law": "sensitivity", "laws": {"sensitivity": {"rate": 3000.0}}}}, "test")
    assert "the loop with these values is unstable: motions grow by a factor of 1.0" in loop_remark(wild)
