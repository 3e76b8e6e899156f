"""Damping entered as the ratio of the first mode: in every form of a robot, and in one place only."""

import pytest

from tendond.model.strain import StrainRod
from tendond.model.strain.analysis.modes import natural_modes
from tendond.model.strain.describe.configured import robot_from_section
from tendond.schemas.config.rig import ConfigError, parse_config
from tendond.schemas.config.rod.presets import PRESETS

SECTION = "[[rod.section]]\nlength = 0.2\nradius = 1e-3\nyoungs_modulus = 2e11\ndensity = 8e3\n"
BBT = "bending_damping = [0.01, 0.01, 0.01]\n"
TAPER = SECTION.replace("radius = 1e-3", "radius = [[0.0, 1e-3], [0.2, 5e-4]]")
NO_GRAVITY = "gravity = [0.0, 0.0, 0.0]\n"


def first_ratio(text: str) -> float:
    """Damping ratio of the first mode of a robot without gravity, by the general rod."""
    rod = StrainRod(robot_from_section(parse_config(text, "rig.toml").rod), 0.01)
    free = rod.loads()
    return float(natural_modes(rod, rod.solve_static(free), free, 2).damping_ratio[0])


@pytest.mark.parametrize(
    "text",
    [
        f"[rod]\n{NO_GRAVITY}damping_ratio = 0.07\n",
        f"[rod]\n{NO_GRAVITY}damping_ratio = 0.07\ntip_mass = 0.02\n",
        f"[rod]\n{NO_GRAVITY}damping_ratio = 0.07\n{SECTION}{SECTION}",
        f"[rod]\n{NO_GRAVITY}{TAPER}damping_ratio = 0.07\n",
        *(f'[rod]\npreset = "{name}"\n{NO_GRAVITY}damping_ratio = 0.07\n' for name in PRESETS),
    ],
)
def test_the_first_mode_has_the_ratio_that_is_given(text: str) -> None:
    assert first_ratio(text) == pytest.approx(0.07, rel=0.02)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"[rod]\ndamping_ratio = 0.1\n{BBT}", "rig.toml:2: rod.damping_ratio: is described by bending_damping too"),
        (
            f"[rod]\n{SECTION}damping_ratio = 0.1\n{BBT}",
            "rod.section[0].damping_ratio: is described by bending_damping",
        ),
        (f"[rod]\ndamping_ratio = 0.1\n{SECTION}{BBT}", "rig.toml:2: rod.damping_ratio: has no effect: every"),
        (f"[rod]\n{BBT}{SECTION}", "rig.toml:2: rod.bending_damping: is described by [[rod.section]] too"),
    ],
)
def test_a_second_damping_is_refused_in_a_line(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        parse_config(text, "rig.toml")
    (line,) = str(refused.value).splitlines()
    assert said in line
    assert line.endswith("remove one of them")


def test_sections_with_a_damping_of_their_own_replace_the_ratio_of_a_preset() -> None:
    own = parse_config(f'[rod]\npreset = "rao-2021"\n{SECTION}{BBT}{SECTION}{BBT}', "rig.toml").rod
    assert own.damping_ratio is None
    assert parse_config(f'[rod]\npreset = "rao-2021"\n{SECTION}{SECTION}', "rig.toml").rod.damping_ratio == 0.02
