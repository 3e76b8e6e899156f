"""`tendond servo identify`: the dynamics of a servo, by a step test or from a recorded run."""

from contextlib import suppress
from pathlib import Path

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask, status_in
from tendond.cli.common import stop_on_signals
from tendond.cli.servo.rig import confirm, servo_rig
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.tools.calibrate import Ask
from tendond.drivers.dynamixel.tools.rig import open_bus
from tendond.drivers.dynamixel.tools.step_test import step_test
from tendond.model.tendons.servo_fit import ServoFit, fit_steps
from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.identification.servo_log import SHOWN, fit_recording
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import Mode
from tendond.schemas.motors import XL430_W250
from tendond.schemas.requests import ControlAction

LOOK_SECONDS = 0.5
"""Time for which a controller is looked for [s]."""


def identify_servo(config_file: Path | None, tendon: int, travel: float, yes: bool, ask_operator: Ask) -> ServoFit:
    """Step a slack tendon, fit its servo's dynamics, and print the keys of the configuration.

    Args:
        config_file: configuration of the rig.
        tendon: number of the tendon.
        travel: length that is paid out and taken up again [m].
        yes: do not ask before it moves.
        ask_operator: asks the operator.

    Raises:
        TendondError: the rig is armed, there is no such tendon or calibration, an error of the servo, or the operator
            said no.
    """
    rig = servo_rig(config_file)
    _refuse_armed(rig.config)
    if not 0 <= tendon < len(rig.ids):
        raise ServoError(f"there is no tendon {tendon}: they are 0 to {len(rig.ids) - 1}")
    stopped = stop_on_signals()
    calibration = rig.calibration()
    with open_bus(rig.section) as bus:
        located = rig.locate(bus, calibration, {})[tendon]
        if located.doubt:
            raise ServoError(f"tendon {tendon}: {located.doubt}: run 'tendond servo home' first")
        confirm(f"Pay out tendon {tendon} by {travel * 1e3:g} mm and take it up again, six times?", yes, ask_operator)
        test = step_test(bus, rig.section, located.spool, rig.tension_max, travel, stopped)
    radius, section = located.spool.calibration.spool_radius, rig.section
    fit = fit_steps(test.steps, section.profile_velocity * radius, max(section.profile_acceleration * radius, 0.1))
    print(report(fit, test.hysteresis, radius, rig.section.motor.tick))
    return fit


def identify_from_log(log: Path, tendon: int) -> ServoFit:
    """Fit a servo's dynamics to a recorded run, and print the keys of the configuration.

    Raises:
        TendondError: the log cannot be read, or does not have the motion and the reports that it takes.
    """
    recording = load_recording(log, {}, from_rest=False)
    section = recording.config.servo or ServoSection()
    radius = section.spool_radius
    fit, backlash = fit_recording(
        recording, tendon, section.profile_velocity * radius, max(section.profile_acceleration * radius, 0.1)
    )
    print(report(fit, backlash, radius, section.motor.tick))
    return fit


def report(fit: ServoFit, hysteresis: float, radius: float, tick: float = XL430_W250.tick) -> str:
    """Write the dynamics with their errors, and the keys of the configuration.

    Args:
        fit: dynamics.
        hysteresis: difference of where the servo rests at one goal, or its backlash [m].
        radius: of the spool [m].
        tick: unit of the servo's positions [rad].
    """
    servo, (dead, rate, acceleration, lag) = fit.servo, fit.error
    step = tick * radius
    delay = fit.dead_time + servo.lag
    seen = {
        "rate": rate <= SHOWN * servo.rate,
        "acceleration": acceleration <= SHOWN * servo.acceleration,
    }
    unseen = " and ".join(name for name, is_seen in seen.items() if not is_seen)
    return "\n".join(
        (
            f"dead time     {fit.dead_time * 1e3:.1f} +- {dead * 1e3:.1f} ms, a read's and a write's included",
            f"lag           {servo.lag * 1e3:.1f} +- {lag * 1e3:.1f} ms",
            f"speed         {servo.rate * 1e3:.1f} +- {rate * 1e3:.2g} mm/s",
            f"acceleration  {servo.acceleration:.2f} +- {acceleration:.2g} m/s^2",
            f"hysteresis    {hysteresis * 1e6:.0f} um, in steps of {step * 1e6:.0f} um; not what is behind the encoder",
            f"residual      {fit.residual * 1e6:.0f} um RMS",
            *([f"not shown by this motion, which is too slow for it: {unseen}"] if unseen else []),
            "",
            "[observer]",
            f"command_delay = {delay:.4f}  # dead time and lag",
            *([f"servo_acceleration = {servo.acceleration:.3g}"] if seen["acceleration"] else []),
            f"backlash = {hysteresis:.2g}",
            "",
            "[simulator.servo]",
            *([f"rate = {servo.rate:.3g}"] if seen["rate"] else []),
            *([f"acceleration = {servo.acceleration:.3g}"] if seen["acceleration"] else []),
            f"lag = {servo.lag:.3g}",
            f"backlash = {hysteresis:.2g}",
            f"resolution = {step:.3g}",
        )
    )


def _refuse_armed(config: RigConfig) -> None:
    """Refuse where a controller runs and is not idle.

    Raises:
        ServoError: it is armed, or releases its tendons.
    """
    with suppress(BusError), open_client(config.bus.endpoint, LOOK_SECONDS) as session:
        status = status_in(ask(session, config.rig.name, ControlAction.STATUS))
        if status.mode not in (Mode.STARTING, Mode.IDLE):
            raise ServoError(f"the controller of rig '{config.rig.name}' is in mode {status.mode.value}: stop it first")
