"""Errors of the daemon."""

from tendond import TendondError
from tendond.schemas.config.rig import ConfigError


class DaemonError(TendondError):
    """Base of the daemon's errors: one line that says what, where, and what to do."""


class BusConfigError(DaemonError, ConfigError):
    """A configuration of the bus that cannot work, in whatever file: as with any, starting again does not help."""


class UsageError(DaemonError):
    """A request of the user that cannot be carried out; the exit status is that of a wrong option."""


class LawError(DaemonError):
    """A law that does not exist, or parameters that it cannot take."""


class LawPackageError(LawError, UsageError):
    """A law of an installed package that cannot be imported, is not a law, or has the name of another one."""


class TargetError(DaemonError):
    """A reference that the rod cannot follow: what was asked, and the nearest that can be."""


class TuningError(DaemonError):
    """A request to tune that cannot be carried out: which key, and what is allowed."""


class SafetyError(DaemonError):
    """Constraints of [safety] that the resting arm breaks: which, by how much, and what to do."""
