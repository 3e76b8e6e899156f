"""The command line. Nothing heavy is imported before a command needs it."""

from tendond.daemon.cli.signals import leave_early

leave_early()  # Ctrl-C while the rest is imported

from tendond.daemon.cli.app import main  # noqa: E402

__all__ = ["main"]
