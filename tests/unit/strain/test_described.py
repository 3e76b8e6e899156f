"""Robots from configurations: short and full form, presets, damping ratios, inheritance, refusals."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.rods.selection import rod_from_section
from tendond.model.strain import Robot, StrainRod
from tendond.model.strain.analysis.modes import natural_modes
from tendond.model.strain.describe.configured import in_world, robot_from_section
from tendond.model.strain.layout import lay_out
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config, parse_config
from tendond.schemas.config.rod.presets import PRESETS

SHORT = """
[rod]
length = 0.3
radius = 0.8e-3
youngs_modulus = 200e9
density = 7850.0
bending_damping = [1e-4, 1e-4, 1e-4]
drag = [0.05, 0.05, 0.05]
tendon_positions = [[0.01, 0.0], [0.0, 0.01], [-0.01, 0.0]]
tendon_stiffness = 1e4
tip_mass = 0.02
tip_offset = [0.0, 0.0, 0.01]
"""
FULL = """
[[rod.section]]
length = 0.3
radius = 0.8e-3
youngs_modulus = 200e9
density = 7850.0
bending_damping = 1e-4
drag = 0.05
[[rod.tendon]]
position = [0.01, 0.0]
stiffness = 1e4
[[rod.tendon]]
position = [0.0, 0.01]
stiffness = 1e4
[[rod.tendon]]
route = [-0.01, 0.0]
stiffness = 1e4
[rod.tip]
mass = 0.02
offset = [0.0, 0.0, 0.01]
"""
TAPERED = """
[[rod.section]]
length = 0.2
radius = [[0.0, 1e-3], [0.2, 0.5e-3]]
youngs_modulus = 200e9
density = 7850.0
damping_ratio = 0.02
disk_number = 4
disk_mass = 1e-3
disk_radius = 0.01
disk_thickness = 0.003
[[rod.section]]
length = 0.1
bending_stiffness = [0.01, 0.02]
torsion_stiffness = 0.01
axial_stiffness = 1e4
mass_per_length = 0.01
precurvature = [0.0, 5.0, 0.0]
damping_ratio = 0.02
[[rod.tendon]]
position = [0.01, 0.0]
end = 0.2
friction = 0.1
[[rod.tendon]]
position = [0.01, 0.0]
turns = 1.0
[[rod.tendon]]
position = [0.01, 0.0]
end_position = [0.002, 0.0]
[rod.base]
position = [0.1, 0.0, 0.0]
orientation = [0.70710678, 0.0, 0.70710678, 0.0]
down = [0.0, 0.0, 1.0]
"""


def robot(text: str) -> Robot:
    return robot_from_section(parse_config(text, "rig.toml").rod)


def same(one: Robot, other: Robot) -> None:
    first, second = lay_out(one), lay_out(other)
    for name in first._fields:
        scale = np.max(np.abs(getattr(first, name)), initial=0.0)
        assert getattr(second, name) == pytest.approx(getattr(first, name), rel=1e-12, abs=1e-12 * scale), name


def test_both_forms_describe_the_same_robot() -> None:
    short, full = (parse_config(text, "rig.toml") for text in (SHORT, FULL))
    assert full.rod == short.rod  # so that controller and simulator run it
    same(robot_from_section(full.rod), robot_from_section(short.rod))


def test_the_general_rod_of_the_short_form_is_the_shooting_rod() -> None:
    config = parse_config(SHORT, "rig.toml")
    shooting, rod = rod_from_section(config.rod, 0.01), StrainRod(robot_from_section(config.rod))
    tensions = [6.0, 0.0, 1.0]
    tip, _ = rod.tip(rod.solve_static(rod.loads(tensions)))
    assert np.linalg.norm(tip - shooting.tip(shooting.solve_static(tensions)).position) < 1e-4 * 0.3


def test_a_tube_has_the_stiffness_of_its_wall() -> None:
    tube = robot(
        "[[rod.section]]\nlength = 0.3\nradius = 1e-3\ninner_radius = 0.8e-3\nyoungs_modulus = 60e9\ndensity = 6450.0\n"
    )
    section = tube.sections[0]
    second, area = math.pi / 4.0 * (1e-12 - 0.8**4 * 1e-12), math.pi * (1e-6 - 0.64e-6)
    assert section.bending_stiffness[0] == pytest.approx(60e9 * second)
    assert section.axial_stiffness == pytest.approx(60e9 * area)
    assert section.mass_per_length == pytest.approx(6450.0 * area)
    assert section.polar_inertia == pytest.approx(6450.0 * 2.0 * second)


def test_all_of_a_full_description_reaches_the_robot() -> None:
    described = robot(TAPERED)
    first, second = described.sections
    assert first.at("bending_stiffness", 0.2)[0] == pytest.approx(200e9 * math.pi / 4.0 * 0.5e-3**4)
    assert second.bending_stiffness == (0.01, 0.02)
    assert second.curvature == (0.0, 5.0, 0.0)
    assert [body.at for body in described.bodies] == pytest.approx([0.05, 0.1, 0.15, 0.2])
    assert described.bodies[0].inertia[2] == pytest.approx(0.5 * 1e-3 * 0.01**2)
    assert [tendon.end for tendon in described.tendons] == pytest.approx([0.2, 0.3, 0.3])
    assert described.tendons[0].friction == 0.1
    assert described.tendons[1].at(0.15) == pytest.approx((-0.01, 0.0))
    assert described.tendons[2].at(0.3) == pytest.approx((0.002, 0.0))
    assert (described.gravity, described.origin) == ((0.0, 0.0, 9.81), (0.0, 0.0, 0.0))  # in its base's frame
    room = in_world(parse_config(TAPERED, "rig.toml").rod)
    assert room.gravity == pytest.approx((9.81, 0.0, 0.0))
    assert room.base @ (0.0, 0.0, 1.0) == pytest.approx((1.0, 0.0, 0.0))
    assert room.origin == (0.1, 0.0, 0.0)


def test_corrections_of_the_whole_robot_add_to_and_multiply_its_description() -> None:
    text = "[rod]\nprecurvature = [0.5, 1.0, 0.0]\ntendon_friction = 0.2\n" + TAPERED
    plain, corrected = robot(TAPERED), robot(text + "[rod.scale]\ntendon_radius = [1.1, 1.2, 1.0]\n")
    assert [one.friction for one in corrected.tendons] == [0.1, 0.2, 0.2]  # the first one has its own
    for one, other in zip(plain.sections, corrected.sections, strict=True):
        assert other.at("curvature", 0.05) == pytest.approx(np.add(one.at("curvature", 0.05), (0.5, 1.0, 0.0)))
    for factor, was, now in zip((1.1, 1.2, 1.0), plain.tendons, corrected.tendons, strict=True):
        assert now.at(0.15) == pytest.approx(np.multiply(factor, was.at(0.15)))
    more = "[rod.scale]\ntendon_radius = [1.0, 1.1, 1.0]\n"
    short, wider = (parse_config(text, "rig.toml").rod for text in (SHORT, SHORT + more))
    assert wider.tendon_positions[1] == pytest.approx(np.multiply(1.1, short.tendon_positions[1]))
    assert "curved without load" in parse_config("[rod]\nprecurvature = [0.0, 1.0, 0.0]\n", "rig.toml").rod.not_uniform


@pytest.mark.parametrize("text", [SHORT, FULL, TAPERED, *(f'[rod]\npreset = "{name}"\n' for name in PRESETS)])
def test_a_description_reads_back_as_itself(text: str) -> None:
    config = parse_config(text, "rig.toml")
    assert check_config(config.model_dump(), "again") == config
    assert RigConfig.model_validate_json(config.model_dump_json()) == config


@pytest.mark.parametrize("text", [TAPERED, '[rod]\npreset = "rao-2021"\n', '[rod]\npreset = "nitinol"\n'])
def test_the_first_mode_has_the_damping_ratio_that_was_asked_for(text: str) -> None:
    rod = StrainRod(robot(text))
    free = StrainRod(Robot(rod.robot.sections, (), rod.robot.bodies))
    assert natural_modes(free, free.rest(), free.loads()).damping_ratio[0] == pytest.approx(0.02, rel=2e-3)


def test_a_free_release_decays_as_the_damping_ratio_says() -> None:
    """Logarithmic decrement over ten periods, 2 pi zeta / sqrt(1 - zeta^2) a period."""
    ratio = 0.03
    text = SHORT.replace("bending_damping = [1e-4, 1e-4, 1e-4]\ndrag = [0.05, 0.05, 0.05]", f"damping_ratio = {ratio}")
    described = robot(f"{text}drag = [0.0, 0.0, 0.0]\ngravity = [0.0, 0.0, 0.0]\n")
    period = 1.0 / StrainRod(described).frequencies(StrainRod(described).rest(), StrainRod(described).loads())[0]
    rod = StrainRod(described, period / 400.0)
    state = rod.solve_static(rod.loads(tip_force=(0.01, 0.0, 0.0)))
    energy = []
    for _ in range(11):
        energy.append(rod.energy(state))
        for _ in range(400):
            state = rod.step(state, rod.loads())
    decrement = 0.5 * math.log(energy[0] / energy[10]) / 10.0
    assert decrement == pytest.approx(2.0 * math.pi * ratio / math.sqrt(1.0 - ratio**2), rel=0.02)


@pytest.mark.parametrize(
    ("rod", "plant", "length", "modulus"),
    [
        ("length = 0.3", "", 0.3, 190e9),
        ("length = 0.3", "youngs_modulus = 180e9", 0.3, 180e9),
        ('preset = "till-2019"', "", 0.7144, 207e9),
        ('preset = "rucker-webster-2011"', 'preset = "paper"', 0.5, 190e9),
        ('preset = "till-2019"\nlength = 0.6', "length = 0.5", 0.5, 207e9),
    ],
)  # fmt: skip
def test_the_simulated_rod_is_the_configured_one_but_for_its_own_keys(
    rod: str, plant: str, length: float, modulus: float
) -> None:
    found = parse_config(f"[rod]\n{rod}\n[simulator.rod]\n{plant}\n", "rig.toml").simulator.rod
    assert (found.length, found.youngs_modulus) == (length, modulus)


def test_what_one_section_cannot_be_is_named_where_the_shooting_rod_would_run_it() -> None:
    cases: dict[str, Any] = {
        "rod.section: 2 sections": TAPERED,
        "section[0].precurvature": SECTION + "precurvature = [0.0, 1.0, 0.0]\n",
        "section[0].radius": SECTION.replace("1e-3", "[[0.0, 1e-3], [0.3, 0.5e-3]]"),
        "section[0].bending_stiffness": SECTION + "bending_stiffness = [0.1, 0.2]\n",
        "section[0].disk_number": SECTION + "disk_number = 3\ndisk_mass = 0.001\n",
        "tendon[1].turns": SECTION + "[[rod.tendon]]\nposition = [0.01, 0.0]\n[[rod.tendon]]\n"
        "position = [0.01, 0.0]\nturns = 1.0\n",
        "tendon[0].end": SECTION + "[[rod.tendon]]\nposition = [0.01, 0.0]\nend = 0.1\n",
    }
    for said, text in cases.items():
        rod = parse_config(text, "rig.toml").rod
        with pytest.raises(ParameterError, match=said.replace("[", r"\[")):
            rod_from_section(rod, 0.01)
        assert len(rod.not_uniform.splitlines()) == 1


SECTION = "[[rod.section]]\nlength = 0.3\nradius = 1e-3\nyoungs_modulus = 200e9\ndensity = 7850.0\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[rod]\nlength = 0.2\n" + SECTION, "rig.toml:2: rod.length: is described by [[rod.section]] too"),
        (SECTION.replace("1e-3", "-1.0"), "rig.toml:3: rod.section[0].radius = -1.0: must be a number > 0 and <= 0.5"),
        (SECTION.replace("density = 7850.0", ""), "rod.section[0].mass_per_length: is missing: give it, or radius and"),
        (SECTION + "radii = 1\n", "rig.toml:6: rod.section[0].radii: unknown key; did you mean 'radius'?"),
        (SECTION + "[[rod.tendon]]\nposition = [0.01, 0.0]\nend = 0.4\n", "rig.toml:8: rod.tendon[0].end: 0.4 m lies"),
        (SECTION + "[[rod.tendon]]\nturns = 1\n", "rod.tendon[0].position: give it, or route"),
        (SECTION + "drag = [[0.1, 1.0], [0.05, 2.0]]\n", "s must ascend"),
        (SECTION + "drag = [[0.0, 1.0], [0.4, 2.0]]\n", "its last row is at s = 0.4 m, beyond length = 0.3 m"),
        (SECTION + "damping_ratio = 0.1\nbending_damping = 0.1\n", "damping_ratio: is described by bending_damping"),
        (SECTION + "disk_mass = 0.1\n", "rod.section[0].disk_number: is missing"),
        ('[rod]\npreset = "papers"\n', 'rod.preset = "papers": must be one of "paper", "nitinol"'),
        ("[rod]\ngravity = [0, 0, 1]\n[rod.base]\ndown = [1, 0, 0]\n", "rod.gravity: its direction is described by"),
        ("[rod.base]\ndown = [0, 0, 0]\n", "rod.base.down: must not be zero"),
        ("[rod.scale]\ntendon_radius = [1.1]\n", "rod.scale.tendon_radius: has 1 factors for 4 tendons: give one each"),
    ],
)  # fmt: skip
def test_a_wrong_description_is_refused_with_file_key_and_remedy(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "rig.toml")
    assert said in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1
