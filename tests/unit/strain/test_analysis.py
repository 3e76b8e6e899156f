"""Frames, strain, stress and modes at any place, and the figures that `config check` prints."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.model.strain.analysis.frames import bend, frames, strain_at, strength, tendon_path
from tendond.model.strain.analysis.modes import natural_modes
from tendond.model.strain.analysis.summary import summarise
from tendond.offline.robot_check import robot_report
from tendond.schemas.config.rig import ConfigError, parse_config
from tests.unit.strain.robots import paper

HOW_TO = Path(__file__).parents[3] / "docs" / "howto" / "robot.md"
WEIGHTLESS = (0.0, 0.0, 0.0)


def test_frames_between_nodes_lie_on_the_arc_of_constant_curvature() -> None:
    rod = StrainRod(paper(gravity=WEIGHTLESS))
    state = rod.solve_static(rod.loads([21.0, 1.0, 1.0, 1.0]))
    section = rod.robot.sections[0]
    u, v = 0.02 * 20.0 / section.bending_stiffness[0], 1.0 - 24.0 / section.axial_stiffness
    for s, pose in zip((0.0, 0.111, 0.3, 0.5), frames(rod, state, (0.0, 0.111, 0.3, 0.5)), strict=True):
        arc = (v / u * (1.0 - math.cos(u * s)), 0.0, v / u * math.sin(u * s))
        assert pose[:3, 3] == pytest.approx(arc, abs=1e-6)
        assert pose[:3, 2] == pytest.approx((math.sin(u * s), 0.0, math.cos(u * s)), abs=1e-5)
    assert bend(rod, state) == pytest.approx(u * 0.5, rel=1e-4)
    tip, turn = rod.tip(state)
    last = frames(rod, state, [0.5])[0]
    assert last[:3, 3] == pytest.approx(tip, abs=1e-12)
    assert last[:3, :3] == pytest.approx(turn, abs=1e-12)


def test_a_tendon_s_path_in_space_has_the_length_that_its_displacement_says() -> None:
    section = Section.round(0.2, 5e-4, 200e9, 7850.0)
    rod = StrainRod(Robot((section,), (Tendon.helical(0.18, 0.008, 0.5), Tendon(0.2, (0.008, 0.0)))))
    state = rod.solve_static(rod.loads([1.0, 2.0]))
    for index in range(2):
        lengths = []
        for one in (rod.rest(), state):
            path = tendon_path(rod, one, index, np.linspace(0.0, rod.robot.tendons[index].end, 801))
            lengths.append(np.sum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
        assert lengths[0] - lengths[1] == pytest.approx(rod.displacements(state)[index], abs=5e-7)


def test_stress_of_a_cantilever_s_outermost_fibre() -> None:
    """M r / I at the clamp of a wire and of a tube, for a small load on the tip."""
    for inner in (0.0, 1.5e-3):
        section = Section.tapered(0.2, 2e-3, 100e9, 5000.0, inner_radius=inner, stretch_modes=2)
        rod = StrainRod(Robot((section,)))
        state = rod.solve_static(rod.loads(tip_force=(0.05, 0.0, 0.0)))
        second = math.pi / 4.0 * (2e-3**4 - inner**4)
        found = strength(rod, state, [0.0])
        assert found.stress[0] == pytest.approx(0.05 * 0.2 * 2e-3 / second, rel=1e-3)
        assert found.mises[0] == pytest.approx(found.stress[0], rel=1e-6)
        assert found.strain[0] == pytest.approx(found.stress[0] / 100e9, rel=1e-9)


def test_twist_of_a_shaft_and_its_shear_stress() -> None:
    """2 M / (pi r^3)."""
    section = Section.round(0.2, 2e-3, 100e9, 5000.0)
    rod = StrainRod(Robot((section,), bodies=(Body(0.2, 0.0),)))
    state = rod.solve_static(rod.loads(wrenches=[(0.2, WEIGHTLESS, (0.0, 0.0, 0.1))]))
    assert strain_at(rod, state, [0.1])[0, 2] == pytest.approx(0.1 / section.torsion_stiffness, rel=1e-9)
    assert strength(rod, state, [0.1]).shear[0] == pytest.approx(2.0 * 0.1 / (math.pi * 2e-3**3), rel=1e-9)


@pytest.mark.parametrize("ratio", [0.5, 0.8])
def test_a_stepped_beam_has_the_frequencies_of_its_frequency_equation(ratio: float) -> None:
    """Two uniform pieces of equal length, diameters 1 and `ratio`: determinant of the matching conditions (Euler)."""
    lengths, radii = (0.25, 0.25), (1e-3, ratio * 1e-3)
    sections = tuple(Section.round(L, r, 200e9, 7850.0, bending_modes=6) for L, r in zip(lengths, radii, strict=True))
    rod = StrainRod(Robot(sections))
    found = natural_modes(rod, rod.rest(), rod.loads(), 6).frequency[::2]

    def determinant(omega: float) -> float:
        """Matrix from the clamp's moment and force to the free end's, by (w, w', EI w'', EI w''')."""
        state = np.zeros((4, 2))
        state[2, 0] = state[3, 1] = 1.0
        for section, length in zip(sections, lengths, strict=True):
            EI = section.bending_stiffness[0]
            k = (section.mass_per_length * omega**2 / EI) ** 0.25
            x = k * length
            c, s = math.cosh(x), math.sinh(x)
            a, b, d, e = (c + math.cos(x)) / 2, (s + math.sin(x)) / 2, (c - math.cos(x)) / 2, (s - math.sin(x)) / 2
            transfer = np.array(
                [
                    [a, b / k, d / (k**2 * EI), e / (k**3 * EI)],
                    [k * e, a, b / (k * EI), d / (k**2 * EI)],
                    [k**2 * EI * d, k * EI * e, a, b / k],
                    [k**3 * EI * b, k**2 * EI * d, k * e, a],
                ]
            )
            state = transfer @ state
        return float(np.linalg.det(state[2:]))

    for frequency in found:
        omega = 2.0 * math.pi * float(frequency)
        assert determinant(0.998 * omega) * determinant(1.002 * omega) < 0.0


def test_the_first_mode_of_a_cantilever_has_its_shape() -> None:
    """Blevins, table 8-1: w(L/2) / w(L) = 0.3395."""
    rod = StrainRod(paper(gravity=WEIGHTLESS, bending_modes=6))
    modes = natural_modes(rod, rod.rest(), rod.loads(), 1)
    at = rod.backbone(rod.rest())[:, 2]
    across = np.linalg.norm(modes.motion[0], axis=1)
    assert np.interp(0.25, at, across) / across[-1] == pytest.approx(0.3395, abs=0.005)


def test_a_hanging_chain_swings_as_bessel_says() -> None:
    """Next to no stiffness, gravity along it: omega = 1.2024 sqrt(g / L) (Lamb, Dynamics, section 107)."""
    section = Section(1.0, (2e-5, 2e-5), 2e-5, 1e4, 0.05, 1e-9, bending_modes=8)
    rod = StrainRod(Robot((section,), gravity=(0.0, 0.0, 9.81)))
    rest = rod.solve_static(rod.loads())
    chain = 1.2024 * math.sqrt(9.81) / (2.0 * math.pi)
    assert natural_modes(rod, rest, rod.loads(), 1).frequency[0] == pytest.approx(chain, rel=0.03)


def test_the_figures_of_the_paper_s_robot() -> None:
    """Mass of table 1; sag and frequency of the shooting rod; 60 N bend by T r L / (EI)."""
    found = summarise(StrainRod(paper()), 60.0)
    assert found.mass == pytest.approx(17189.0 * math.pi * 1e-6 * 0.5)
    assert found.frequency[0] == pytest.approx(3.72, rel=0.02)
    assert found.damping_ratio[0] == pytest.approx(0.627, rel=0.02)
    assert max(one.bend for one in found.pulls) == pytest.approx(60.0 * 0.02 * 0.5 / (190e9 * math.pi / 4e12), rel=0.05)
    assert found.time_constant == pytest.approx(1.0 / (0.627 * 2.0 * math.pi * 3.72), rel=0.03)


def test_the_how_to_prints_what_its_robot_is() -> None:
    text = HOW_TO.read_text(encoding="utf-8")
    config = parse_config(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[0], "robot.toml")
    report = robot_report(config)
    assert "\n".join(report.lines) in text
    assert report.notes == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[rod]\nradius = 2e-3\n[limits]\ntension_max = 500.0\n", "rod.yield_strain: at limits.tension_max = 500 N"),
        ("[rod]\nradius = 0.5e-3\n", "more than a turn: write a lower one"),
        ("[rod]\nyoungs_modulus = 2e9\n[limits]\ntension_max = 0.1\n[pretension]\ntension = 0.05\ntension_min = 0.01\n",
         "of its length under its own weight"),
        ("[rod]\nbending_damping = [0, 0, 0]\n", "next to no damping"),
        ("[rod]\nbending_damping = [8, 8, 8]\n", "is overdamped"),
        ("[rod]\nlength = 0.05\n", "is too high for a loop of 100 Hz"),
        ("[rod]\ndensity = 7.85\n", "check the units of radius, density and mass"),
        ("[rod]\ntendon_positions = [[0.0005, 0.0]]\n", "tendon 0 runs inside the backbone"),
        ("[rod]\ntendon_positions = [[20.0, 0.0]]\n", "more than half the length"),
        ('[rod]\ntendon_friction = 0.1\n[control]\nsolver = "shooting"\n', "the friction of tendon 0 has no effect"),
        ('[rod]\npreset = "rao-2021"\nnodes = 20\n', "rod.nodes: is of the shooting rod, which is not this robot's"),
        ("[[rod.section]]\nlength = 0.3\nradius = [[0, 1e-3], [0.3, 8e-4]]\nyoungs_modulus = 2e11\ndensity = 7850.0\n"
         "shear_damping = [1.0, 1.0, 0.0]\n", "rod.section[0].shear_damping: has no effect"),
    ],
)  # fmt: skip
def test_what_no_lab_builds_is_noted(text: str, said: str) -> None:
    assert any(said in note for note in robot_report(parse_config(text, "rig.toml")).notes)


def test_a_rod_comes_from_a_file_a_preset_or_a_configuration(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text('[rod]\npreset = "rao-2021"\n[loop]\nperiod = 0.02\n', encoding="utf-8")
    rod, other = StrainRod.from_config(file), StrainRod.from_config("rao-2021")
    assert (rod.time_step, other.time_step) == (0.02, 0.01)
    assert rod.layout.stiffness == pytest.approx(other.layout.stiffness)
    assert StrainRod.from_config(parse_config(file.read_text(), "x").rod, 0.005).time_step == 0.005
    with pytest.raises(ConfigError, match="a preset is one of paper, nitinol"):
        StrainRod.from_config("rao-2022")
    with pytest.raises(ParameterError, match="s: all must lie on the backbone"):
        frames(rod, rod.rest(), [0.5])
