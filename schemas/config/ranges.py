"""Ranges that several sections of the configuration share."""

from typing import Annotated, Literal

from pydantic import Field

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Port = Annotated[int, Field(ge=1, le=65535)]
Axis = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
"""Axis of another frame, with its sign."""
Voltage = Annotated[float, Field(ge=0.0, le=14.8)]
