"""Control tables of all models that the driver knows, and the model of a number."""

from tendond.drivers.dynamixel.serial import p_series, x_series
from tendond.drivers.dynamixel.serial.model import ServoModel

MODELS = {model.name: model for model in (*x_series.MODELS, *p_series.MODELS)}
"""Models by their name in `servo.model`."""

XL430 = x_series.XL430


def model_of(number: int) -> ServoModel | None:
    """Return the model with a Model Number; none where it is unknown."""
    return next((model for model in MODELS.values() if model.number == number), None)


def name_of(number: int) -> str:
    """Return the name of a Model Number, for people."""
    model = model_of(number)
    return model.name if model else f"model {number}"


def mismatch(number: int, wanted: ServoModel) -> str:
    """Explain why a servo is not of the configured model, with the remedy; empty where it is.

    A rig has servos of one model: they share reads and writes, whose addresses differ, and the limits of `[servo]`.

    Args:
        number: Model Number that the servo reports.
        wanted: model of `servo.model`.
    """
    if number == wanted.number:
        return ""
    found = model_of(number)
    if found is None:
        known = ", ".join(MODELS)
        return f"is model {number}, not {wanted.number} ({wanted.name}), and unknown: replace it by one of {known}"
    return (
        f"is model {number} ({found.name}), not {wanted.number} ({wanted.name}): all servos of a rig are of one model,"
        " set servo.model or replace the servo"
    )
