"""`tendond config new`: a configuration from a dozen answers."""

import re
import shlex
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tendond.cli.common import say
from tendond.cli.config.answers import QUESTIONS, AnswerError, Question, contradictions, number
from tendond.cli.config.check import run_check
from tendond.cli.config.new_text import like_text, rig_text, rod_text, task_text
from tendond.cli.warm.progress import compile_with_progress
from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.files import write_whole
from tendond.offline.kernels import parts_of
from tendond.offline.trying.first_target import RESERVE, SERVO_RESERVE, first_target
from tendond.offline.trying.task import task_of
from tendond.schemas.config.rig import ConfigError, parse_config
from tendond.schemas.config.rod.presets import PRESETS
from tendond.schemas.errors.explain import choose

STIFFNESS = Question("--tendon-stiffness", "", "", number("N/m", 10.0, 1e8))

Ask = Callable[[Question, Callable[[str], Any]], Any]
"""Asks a question until its reader takes the answer, which is returned."""


def run_new(
    file: Path,
    given: Mapping[str, str | None],
    *,
    like: str | None,
    name: str | None,
    yes: bool,
    force: bool,
    ask: Ask,
) -> None:
    """Write a configuration and check it; see `tendond config new --help`.

    Args:
        file: to write.
        given: answers given as options, by the names of `QUESTIONS`.
        like: robot by name to start from. name: of the rig; default: the file's.
        yes: take the defaults without asking. force: overwrite the file.
        ask: see `Ask`.

    Raises:
        UsageError: an answer makes no sense, or is missing; or the file is there already.
        DaemonError: the file cannot be written, or no target can be chosen.
        ConfigError: what was written cannot be used.
    """
    if like is not None and like not in PRESETS:
        raise ConfigError(f"--like '{like}': {choose(like, PRESETS)}; see tendond config presets")
    if file.exists() and not force:
        raise UsageError(f"{file} is there already: give another name, or --force to overwrite it")
    answers = _answers(given, like, yes, ask)
    rod = rod_text(answers) if like is None else like_text(like, answers)
    head = f"# Written by `tendond config new`; every key: `tendond config show {shlex.quote(str(file))}`. SI units.\n"
    robot = parse_config(f"{rod}\n[loop]\nperiod = {round(1.0 / answers['rate'], 9)}\n", "the robot")
    compile_with_progress(parts_of(robot), len(robot.rod.tendon_positions))
    reserve = RESERVE if answers["servos"] == "none" else SERVO_RESERVE
    task = task_text(task_of(robot, first_target(robot), reserve))
    text = "\n".join([head, rig_text(name or _name_of(file), answers), rod, task])
    try:
        write_whole(file, text)
    except OSError as error:
        raise DaemonError(f"{file}: cannot be written: {error.strerror}; choose another place") from error
    print(f"{file}: written", flush=True)
    run_check(file, None, as_json=False)
    print(f"next: tendond try {shlex.quote(str(file))}")


def _answers(given: Mapping[str, str | None], like: str | None, yes: bool, ask: Ask) -> dict[str, Any]:
    """Return the answers by name: those given, then those asked for or by default.

    Raises:
        UsageError: an answer makes no sense, or is missing.
    """
    answers: dict[str, Any] = {}
    for question in (*QUESTIONS, STIFFNESS):
        if (text := given.get(question.name)) is not None:
            try:
                answers[question.name] = question.read(text)
            except AnswerError as error:
                raise UsageError(f"{question.flag}: {error}") from error
    if like is not None:
        _check_like(like, answers)
    open_ones = [one for one in QUESTIONS if one.name not in answers and not (like and one.of_robot)]
    if open_ones and not yes and not sys.stdin.isatty():
        raise UsageError(
            f"not a terminal, so nothing is asked: give {', '.join(one.flag for one in open_ones)}, or --yes for the "
            "defaults"
        )
    for question in open_ones:
        answers[question.name] = question.read(question.default) if yes else _asked(question, answers, ask)
    if wrong := contradictions(answers):
        raise UsageError("\n".join(wrong))
    return answers


def _asked(question: Question, answers: Mapping[str, Any], ask: Ask) -> Any:
    """Ask a question until its answer fits those before it."""

    def read(text: str) -> Any:
        value = question.read(text)
        if wrong := contradictions({**answers, question.name: value}):
            raise AnswerError(wrong[0])
        return value

    return ask(question, read)


def _check_like(like: str, answers: Mapping[str, Any]) -> None:
    """Refuse answers that do not go over a preset.

    Raises:
        UsageError: says which.
    """
    if ("tendons" in answers) != ("tendon_radius" in answers):
        raise UsageError("--tendons and --tendon-radius: give both, or neither, with --like")
    if "mass" in answers:
        raise UsageError("--mass: not with --like, whose robot has a density: write rod.density")
    described = [name for name in ("length", "diameter", "material", "tendons") if name in answers]
    if "section" in PRESETS[like] and (described or "tendon_stiffness" in answers):
        flag = f"--{(described or ['tendon_stiffness'])[0].replace('_', '-')}"
        raise UsageError(
            f"{flag}: '{like}' has sections and tendons of its own: edit what "
            f"`tendond config show --preset {like}` prints"
        )


def _name_of(file: Path) -> str:
    """Make a rig's name of a file's."""
    found = re.sub(r"[^a-z0-9_-]+", "-", file.stem.lower()).strip("-_")[:32]
    if not found:
        say("the file's name makes no name of a rig: 'arm' is taken")
    return found or "arm"
