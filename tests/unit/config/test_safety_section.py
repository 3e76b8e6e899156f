"""[safety]: what is refused, in one line each, and what it changes elsewhere."""

import pytest

from tendond.schemas.config.rig import ConfigError, RigConfig, parse_config

SPHERE = '[[safety.obstacle]]\nkind = "sphere"\ncenter = [0.2, 0.0, 0.3]\nradius = 0.05\n'


def test_it_is_off_by_default_and_not_written() -> None:
    assert RigConfig().safety is None
    assert "safety" not in RigConfig().model_dump(mode="json")


def test_it_selects_the_general_rod() -> None:
    config = parse_config(SPHERE, "test")
    assert config.control.solver == "general"
    assert config.safety is not None
    assert config.safety.labels == ("obstacle 1",)
    assert RigConfig.model_validate_json(config.model_dump_json()) == config


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[control]\nsolver = "shooting"\n[safety]\n', "needs the general rod"),
        ('[[safety.obstacle]]\nkind = "sphere"\ncenter = [0, 0, 1]\n', "radius: is missing"),
        ('[[safety.obstacle]]\nkind = "half_space"\npoint = [0, 0, 1]\nnormal = [0, 0, 0]\n', "must not be zero"),
        (
            '[[safety.obstacle]]\nkind = "half_space"\nradius = 0.1\npoint = [0, 0, 1]\nnormal = [0, 0, 1]\n',
            "remove it",
        ),
        ('[safety.tip_region]\nkind = "box"\nlow = [0, 0, 0]\nhigh = [1, 0, 1]\n', "the region is empty"),
        (SPHERE.replace("kind", 'name = "a"\nkind') * 2, "same name"),
        ("[safety]\nmargin = -1.0\n", "safety.margin = -1.0"),
    ],
)
def test_what_cannot_be_is_refused_by_key(text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said) as refused:
        parse_config(text, "test")
    assert len(str(refused.value).splitlines()) == 1
    assert "safety" in str(refused.value)
