"""Requests of an operator to the controller, and its replies: JSON, each request a queryable of its own."""

from enum import StrEnum
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import SCHEMA_VERSION, Schema
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.messages import Status


class ControlAction(StrEnum):
    """Action of an operator's request; each is a queryable, `<rig>/control/<action>`."""

    ARM = "arm"
    PROBE = "probe"
    STOP = "stop"
    RESET = "reset"
    STATUS = "status"
    REFERENCE = "reference"
    LAW = "law"
    SET = "set"
    JOG = "jog"


Settings = Annotated[dict[Annotated[str, Field(max_length=128)], float], Field(min_length=1, max_length=16)]
"""Values by key of the configuration, in the key's unit."""


class ControlRequest(Schema):
    """A request by an operator.

    Attributes:
        action: action to carry out.
        law: law to select, with the action `law`.
        reference: reference to set, with the action `reference`; with its samples, not a file.
        settings: values by tunable key, with the action `set`.
        jog: speed of the target along the tips of resting shapes, positive away from the straight rod [m/s], with the
            action `jog`; it counts for `teleop.timeout`.
        controller: identity of the addressed controller, from its status; empty: any.
        deadline_ns: time on that controller's monotonic clock [ns], the clock of its status' `stamp_ns`, after which
            the request is refused. Without one, a request that may have waited for half a second is refused. A stop is
            always carried out.
    """

    REQUIRED: ClassVar[frozenset[str]] = frozenset({"version"})

    version: Literal[1] = SCHEMA_VERSION
    action: ControlAction
    law: Annotated[str, Field(max_length=64)] | None = None
    reference: ReferenceSection | None = None
    settings: Settings | None = None
    jog: float | None = None
    controller: Annotated[str, Field(max_length=64)] = ""
    deadline_ns: Annotated[int, Field(ge=0)] | None = None

    @model_validator(mode="after")
    def _fits(self) -> "ControlRequest":
        if (self.law is not None) != (self.action is ControlAction.LAW):
            raise ValueError("a law goes with the action 'law'")
        if (self.reference is not None) != (self.action is ControlAction.REFERENCE):
            raise ValueError("a reference goes with the action 'reference'")
        if (self.settings is not None) != (self.action is ControlAction.SET):
            raise ValueError("settings go with the action 'set'")
        if (self.jog is not None) != (self.action is ControlAction.JOG):
            raise ValueError("a speed goes with the action 'jog'")
        named = self.reference
        if named is not None and named.kind in ("samples", "path") and not (named.samples or named.waypoints):
            raise ValueError("the samples are missing: a file's name means nothing to another process")
        return self


class ControlReply(Schema):
    """Reply to an operator's request.

    Attributes:
        done: the request was carried out.
        message: report of what was done, or reason for a refusal, in one line.
        status: status of the controller afterwards.
    """

    version: Literal[1] = SCHEMA_VERSION
    done: bool
    message: str
    status: Status | None = None
