"""The command line. Nothing heavy is imported before a command needs it."""

from tendond.cli.signals import exit_early

exit_early()  # Ctrl-C while the rest is imported

from tendond.cli.app import main  # noqa: E402

__all__ = ["main"]
