"""Paragraphs of the page about the runs on the simulated rig."""

import numpy as np

from tendond.model.estimation.observer_gains import NOISE_FLOOR
from tendond.offline.paper.facts import deviation, mean_error, off
from tendond.offline.paper.published import EXPERIMENT, LAWS
from tendond.offline.paper.run import Runs
from tendond.offline.paper.scenarios import RIG
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.motors import XL430_W250

BACK, SLIDE = LAWS

WINDOW = 50
"""Iteration from which on impacts are evaluated: the arm has arrived."""


def rig_paragraphs(runs: Runs) -> list[str]:
    run = runs["rig_normal", BACK]
    config, simulator = run.scenario.config, run.scenario.config.simulator
    period = config.loop.period
    rise = EXPERIMENT[BACK].rise_iterations
    pulled = float(run.displacement[rise] - run.displacement[0])
    speed = pulled / (rise * period)
    servo = ServoSection()
    able = XL430_W250.no_load_speed * servo.spool_radius
    rod = RIG["simulator"]["rod"]
    plant, model = simulator.rod, config.rod
    return [
        "'Ours' is not a rig but a simulated plant that differs from the controller's model as a rig would. "
        f"Tendons are strings of {rod['tendon_stiffness']:.3g} N/m (the model has {model.tendon_stiffness:.3g}) pulled "
        "by "
        f"servos with {1e3 * simulator.servo.lag:g} ms of lag, {1e3 * simulator.servo.backlash:g} mm of backlash and "
        "steps "
        f"of {1e6 * simulator.servo.resolution:g} um; poses are {1e3 * simulator.mocap.latency:g} ms old with "
        f"{1e3 * simulator.mocap.noise:g} mm of noise; the rod has E x "
        f"{plant.youngs_modulus / model.youngs_modulus:.2f}, "
        f"rho x {plant.density / model.density:.2f}, Bbt x {plant.bending_damping[0] / model.bending_damping[0]:.2f}. "
        "The "
        "controller is configured with delay and lag. Its scheme is the converged one, so z is that of a real rod.",
        f"The servos have no rate limit here, because the paper's numbers do not allow one: to rise in {rise} "
        "iterations "
        "our "
        f"run pulls {1e3 * pulled:.0f} mm, at {1e3 * period:g} ms an iteration {speed:.2f} m/s. An XL430-W250-T turns "
        "at "
        f"{XL430_W250.no_load_speed * 60 / (2 * np.pi):.0f} rpm maximum, {able:.3f} m/s on a spool of "
        f"{1e3 * servo.spool_radius:g} mm. "
        f"Either the experiment's iterations lasted {1e3 * pulled / (rise * able):.0f} ms or more, or its spools had a "
        f"radius of {1e3 * speed / XL430_W250.no_load_speed:.0f} mm or more; the paper gives neither.",
        f"The steady-state error is {mean_error(run, 100, 120):.2f} mm at iteration 100 and "
        f"{mean_error(run, -20, None):.2f} mm at the end: the observer treats innovations below "
        f"{1e3 * NOISE_FLOOR * config.rod.length:.2g} mm mostly as noise and corrects them slowly.",
    ]


def rig_load_paragraphs(runs: Runs) -> list[str]:
    start = WINDOW
    name = "rig_impacts"
    deflection = {law: deviation(runs[name, law], start) for law in LAWS}
    rms = {law: float(np.sqrt(np.mean(np.sum((off(runs[name, law])[start:]) ** 2, axis=1)))) * 1e3 for law in LAWS}
    return [
        f"The impacts move the tip by up to {deflection[BACK]:.0f} mm (backstepping) and "
        f"{deflection[SLIDE]:.0f} mm (sliding mode), "
        f"{rms[BACK]:.1f} and {rms[SLIDE]:.1f} mm RMS from iteration {start} on: sliding mode deviates "
        f"{rms[SLIDE] / rms[BACK]:.2f} times as much. In the paper it also deviates more. A weight on a string keeps "
        "swinging "
        "when the arm has come to rest; the remaining motion is the pendulum's.",
    ]
