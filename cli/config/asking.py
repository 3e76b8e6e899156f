"""Questions on the terminal."""

from collections.abc import Callable
from typing import Any

import typer

from tendond.cli.config.answers import AnswerError, Question


def ask(question: Question, read: Callable[[str], Any]) -> Any:
    """Ask until the answer can be read, and return what was read; Enter takes the default."""

    def checked(text: str) -> Any:
        try:
            return read(text)
        except AnswerError as error:
            raise typer.BadParameter(str(error)) from error

    return typer.prompt(question.text, default=question.default, value_proc=checked)
