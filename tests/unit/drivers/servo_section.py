"""Limits of the servo driver under test, without units of their own: every bound has a different value."""

from tendond.schemas.config.servo import ServoSection

SECTION = ServoSection(
    period=0.01,
    displacement_min=-0.08,
    displacement_max=0.06,
    displacement_rate=0.08,
    release_rate=0.05,
    slow_rate=0.01,
    temperature_max=65.0,
    voltage_min=10.0,
    voltage_max=12.5,
    home_window=0.01,
    load_time=0.25,
    following_error=0.01,
    following_time=0.5,
)
