"""`tendond config new`: a file from answers that is checked and can be tried; what makes no sense is refused."""

import io
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tendond.cli.config.answers import QUESTIONS, AnswerError, Question, contradictions, material, number
from tendond.cli.config.asking import ask
from tendond.cli.config.new import run_new
from tendond.daemon.errors import UsageError
from tendond.offline.equilibria_check import equilibria
from tendond.offline.trying.task import has_own_task, trial
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.config.rod.materials import MATERIALS
from tendond.schemas.config.rod.presets import ABOUT, PRESETS
from tests.unit.cli.commands import tendond

HOWTO = Path(__file__).parents[3] / "docs" / "howto" / "robot.md"


def written(path: Path) -> RigConfig:
    return parse_config(path.read_text(), str(path))


def test_the_defaults_make_a_file_that_is_checked_and_names_the_next_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "arm.toml"
    ended = tendond(capsys, "config", "new", str(file), "--yes")
    assert (ended.status, ended.said) == (0, "")
    first, *_, last = ended.out.splitlines()
    assert (first, last) == (f"{file}: written", f"next: tendond try {file}")
    assert f"{file}: OK; rig 'arm'" in ended.out
    config = written(file)
    assert config.rod.length == 0.3
    assert has_own_task(config.reference)
    assert trial(config, None).config.limits.tension_max == config.limits.tension_max < 20.0
    for line in file.read_text().splitlines():
        if re.match(r"\w+ = ", line):
            assert "# " in line, f"no unit or meaning: {line}"


def test_the_answers_given_as_options_are_in_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "lab.toml"
    options = {
        "--length": "250mm", "--diameter": "1.4 mm", "--material": "nitinol", "--mass": "6g", "--tip-mass": "0.002",
        "--tendons": "4", "--tendon-radius": "8e-3", "--gravity": "-z", "--damping-ratio": "6%", "--camera": "vicon",
        "--servos": "dynamixel", "--rate": "200", "--tendon-stiffness": "15 N/mm", "--name": "bench",
    }  # fmt: skip
    ended = tendond(capsys, "config", "new", str(file), *(part for pair in options.items() for part in pair))
    assert ended.status == 0, ended.said
    config = written(file)
    rod = config.rod
    assert (rod.length, rod.radius, rod.youngs_modulus, rod.tip_mass) == (0.25, 7e-4, 54e9, 0.002)
    assert rod.density * 3.14159265 * rod.radius**2 * rod.length == pytest.approx(6e-3)
    assert rod.tendon_positions == ((0.008, 0.0), (0.0, 0.008), (-0.008, 0.0), (0.0, -0.008))
    assert (rod.gravity, rod.tendon_stiffness) == ((0.0, 0.0, -9.81), 15e3)
    assert (config.rig.name, config.loop.period, config.simulator.period) == ("bench", 0.005, 0.005)
    assert config.vicon is not None
    assert config.servo is not None
    assert "damping_ratio = 0.06" in file.read_text()
    assert trial(config, None).config.simulator.drive == "displacement"
    target = next(one for one in equilibria(config) if one.target)
    assert config.limits.tension_max > 4.5 * target.tension, "loads that servos report pass the probe"


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_is_a_start(preset: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "arm.toml"
    ended = tendond(capsys, "config", "new", str(file), "--like", preset, "--yes", "--damping-ratio", "0.04")
    assert ended.status == 0, ended.said
    config = written(file)
    assert config.rod.preset == preset
    assert f"assumed: {ABOUT[preset].assumed}" in file.read_text()
    assert trial(config, None).config.reference == config.reference


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--length", "300"), "--length: 300 m is not within 0.01 to 10 m; if it is in mm, write 0.3"),
        (("--diameter", "1,2mm"), "--diameter: '1,2mm' is not a number in m, or with m, cm, mm, um behind it"),
        (("--tip-mass", "15"), "if it is in g, write 0.015"),
        (("--damping-ratio", "3"), "if it is in per cent, write 0.03"),
        (("--material", "niti"), "--material: 'niti': give E in Pa and the density in kg/m^3, 68e9,2700, or choose"),
        (("--material", "200,7850"), "if it is in GPa, write 2e+11"),
        (("--tendons", "3.5"), "--tendons: '3.5' is not a whole number from 1 to 16"),
        (("--gravity", "down"), "--gravity: 'down': choose one of -x, +x"),
        (("--tendon-radius", "0.2"), "--tendon-radius 0.2 m is more than half of --length 0.3 m"),
        (("--tendon-radius", "0.0002"), "lies inside a backbone of --diameter 0.001 m"),
        (("--diameter", "0.05", "--length", "0.1", "--tendon-radius", "0.03"), "no slender rod"),
        (("--like", "rao"), "--like 'rao': choose one of paper, nitinol"),
        (("--like", "rao-2021", "--length", "0.3"), "--length: 'rao-2021' has sections and tendons of its own"),
        (("--like", "nitinol", "--tendons", "4"), "--tendons and --tendon-radius: give both, or neither"),
        (("--like", "nitinol", "--mass", "0.01"), "--mass: not with --like"),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_line_and_nothing_is_written(
    options: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, "config", "new", str(tmp_path / "arm.toml"), *options, "--yes")
    assert ended.status == 2
    assert said in ended.said
    assert len(ended.said.splitlines()) == 1
    assert not (tmp_path / "arm.toml").exists()


def test_a_file_that_is_there_is_kept_without_force(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "arm.toml"
    file.write_text("# mine\n")
    refused = tendond(capsys, "config", "new", str(file), "--yes")
    assert refused.status == 2
    assert "is there already: give another name, or --force" in refused.said
    assert file.read_text() == "# mine\n"
    assert tendond(capsys, "config", "new", str(file), "--yes", "--force").status == 0
    assert "[rod]" in file.read_text()


def test_without_a_terminal_the_missing_options_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, "config", "new", str(tmp_path / "arm.toml"), "--length", "0.3", "--rate", "100")
    assert ended.status == 2
    assert ended.said.startswith("tendond: not a terminal, so nothing is asked: give --diameter, --material, ")
    assert ended.said.endswith("--servos, or --yes for the defaults\n")


def test_on_a_terminal_each_open_question_is_asked_until_its_answer_fits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    asked: list[str] = []
    refused: list[str] = []

    def answer(question: Question, read: Callable[[str], Any]) -> Any:
        asked.append(question.flag)
        if question.flag == "--tendon-radius":
            for wrong in ("wide", "0.24"):
                with pytest.raises(AnswerError) as error:
                    read(wrong)
                refused.append(str(error.value))
        return read(question.default)

    file = tmp_path / "arm.toml"
    run_new(file, {"length": "0.2"}, like=None, name=None, yes=False, force=False, ask=answer)
    assert asked == [one.flag for one in QUESTIONS if one.flag != "--length"]
    assert refused == ["'wide' is not a number in m, or with m, cm, mm, um behind it", refused[1]]
    assert "more than half of --length 0.2 m" in refused[1]
    asked.clear()
    run_new(file, {}, like="paper", name=None, yes=False, force=True, ask=answer)
    assert asked == ["--camera", "--servos", "--rate"]
    capsys.readouterr()


def test_a_prompt_repeats_its_question_and_takes_the_default(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("300\n\n0.25\n"))
    assert ask(QUESTIONS[0], QUESTIONS[0].read) == 0.3
    assert "if it is in mm, write 0.3" in "".join(capsys.readouterr())
    assert ask(QUESTIONS[0], QUESTIONS[0].read) == 0.25


def test_materials_have_what_a_rod_needs_and_any_other_is_given_by_two_numbers() -> None:
    for name in MATERIALS:
        assert {"youngs_modulus", "density", "poisson_ratio", "yield_strain", "source"} == set(material(name))
    assert material("68e9, 2700")["youngs_modulus"] == 68e9
    assert number("m", 0.0, 1.0)("12 cm") == 0.12
    assert contradictions({"length": 0.2}) == []
    with pytest.raises(UsageError):
        run_new(Path("/nowhere"), {"rate": "fast"}, like=None, name=None, yes=True, force=False, ask=ask)


def test_the_presets_are_listed_with_their_sources_and_in_the_how_to(capsys: pytest.CaptureFixture[str]) -> None:
    assert set(ABOUT) == set(PRESETS)
    out = tendond(capsys, "config", "presets").out
    page = HOWTO.read_text()
    for name, about in ABOUT.items():
        assert name in out
        assert f"source: {about.source}; assumed: {about.assumed}" in out
        assert f"| `{name}` | {about.robot} | {about.source} | {about.assumed} |" in page
