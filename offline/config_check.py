"""Checks of a configuration beyond its keys and values: laws, the rod, the simulator, files that it names."""

import math
import tomllib
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from tendond import TendondError
from tendond.daemon.control.laws import LAWS, select_law
from tendond.daemon.errors import DaemonError, LawError
from tendond.model.numerics.announce import announce_compilation
from tendond.schemas.config.control import ControlSection
from tendond.schemas.config.given import by_default
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.config.rod.compare import difference_remark, figures
from tendond.schemas.config.rod.swing import swings
from tendond.schemas.errors.explain import Objection, objection_from
from tendond.schemas.errors.toml_lines import key_lines, line_of

CHECKED_BEND = 60.0
"""Bend at which the loop of a law that may swing the arm is looked at [degrees], as `tendond study stability` does."""


def located(lines: Iterable[str], file: Path | None) -> list[Objection]:
    """Turn messages into objections with their lines in the file."""
    places = {} if file is None else key_lines(file.read_text(encoding="utf-8-sig"))
    found = [objection_from(line) for line in lines]
    return [replace(one, line=line_of(one.path, places)) for one in found]


def control_of(file: Path | None) -> ControlSection | None:
    """Read [control] of an invalid file; none if it is invalid itself."""
    if file is None:
        return None
    try:
        return ControlSection.model_validate(tomllib.loads(file.read_text(encoding="utf-8-sig")).get("control", {}))
    except ValidationError:
        return None


def law_objections(control: ControlSection | None) -> list[str]:
    """Check the law's name and the laws' parameters; a message for each error."""
    try:
        if control is not None:
            select_law(control.law, control.laws)
    except LawError as error:
        return str(error).splitlines()
    return []


def start_objections(config: RigConfig, say: Callable[[str], None]) -> Iterator[str]:
    """Build controller and simulator as they start, for an unknown law with one that fits; a message for each error."""
    from tendond.daemon.control.setup import CycleSetup
    from tendond.daemon.control.state import initial_state
    from tendond.drivers.simulator.plant import Plant
    from tendond.drivers.simulator.rods import plant_rod
    from tendond.model import ModelError

    announce_compilation(say)
    law = LAWS.get(config.control.law)
    fit = (name for name, one in LAWS.items() if one.task_space.follows(config.reference))
    name = config.control.law if law is not None else next(fit)
    control = config.control.model_copy(update={"law": name, "laws": {}})
    try:
        initial_state(CycleSetup.from_config(config.model_copy(update={"control": control})))
    except (DaemonError, ModelError) as error:
        yield from str(error).splitlines()
    try:
        Plant(config, plant_rod(config.simulator, config.simulator.period)).step(None)
    except ModelError as error:
        yield f"simulator.rod: {error}"


FINE_NODES = 41
"""Nodes of the comparison: the sixth-order scheme differs from the fourth-order one with 200 nodes by
a maximum of 0.1 mm."""

RESOLVED = 0.005
"""Largest difference of the tip, as a fraction of the rod's length, that is not reported."""


def resolution_remarks(config: RigConfig) -> Iterator[str]:
    """Compare the rod's tip at limits.tension_max with that of a finer rod; a message where its nodes are too few."""
    import numpy as np

    from tendond.model import ModelError
    from tendond.model.rods.selection import rod_from_section, source_of

    if source_of(config).solver == "general":
        return  # it has no nodes to choose, and estimates its own error
    tensions = [0.0] * len(config.rod.tendon_positions)
    tensions[config.control.agonist] = config.limits.tension_max
    tips = []
    try:
        for section in (config.rod, config.rod.model_copy(update={"space": "rk6", "nodes": FINE_NODES})):
            rod = rod_from_section(section, config.loop.period)
            tips.append(rod.tip(rod.solve_static(tensions)).position)
    except ModelError:
        return  # a bend without a solution is the solver's fault while running, and named there
    error = float(np.linalg.norm(tips[0] - tips[1]))
    if error > RESOLVED * config.rod.length:
        yield (
            f"rod.nodes{by_default(config.rod, 'nodes')}: at limits.tension_max = {config.limits.tension_max:g} N"
            f"{by_default(config.limits, 'tension_max')} the tip is {error * 1e3:.1f} mm"
            f" from that of a rod with {FINE_NODES} nodes: set more rod.nodes, or a lower limits.tension_max"
        )


def remarks(config: RigConfig, file: Path | None) -> Iterator[str]:
    """Yield what is valid, but keeps a process from running as the machine is now, or makes it run badly."""
    from tendond.daemon.control.gains import lowered, mass_remark
    from tendond.daemon.runtime.bus import hub_settings
    from tendond.drivers.dynamixel.calibration import load_calibration
    from tendond.drivers.mocap.source import missing_library
    from tendond.model import ModelError
    from tendond.model.rods.selection import model_rod

    try:
        hub_settings(config)
    except ConfigError as error:
        yield str(error)
    if not law_objections(config.control):  # the gains depend on the laws
        with suppress(ModelError):  # reported as an error already
            rod = model_rod(config).parameters
            yield from filter(None, (lowered(config, rod), mass_remark(config, rod)))
    yield from _swinging(config)
    if difference := difference_remark(figures(config.simulator.rod), figures(config.rod)):
        yield difference
    frame, allowed = config.simulator.mocap.period or config.simulator.period, config.faults.pose_timeout
    if allowed < 2.0 * frame:
        timeout = f"faults.pose_timeout = {allowed * 1e3:g} ms{by_default(config.faults, 'pose_timeout')}"
        yield (
            f"the simulated camera sends a pose each {frame * 1e3:g} ms{_frame_key(config)}, and {timeout} covers less "
            "than one lost frame: write a longer one, or a shorter period of the camera"
        )
    elif frame > 3.0 * config.loop.period:
        yield (
            f"the simulated camera sends a pose each {frame * 1e3:g} ms{_frame_key(config)}, the loop runs each "
            f"{config.loop.period * 1e3:g} ms: most cycles have no new pose and rely on the model"
        )
    if config.cameras is not None and (missing := missing_library(config.cameras)):
        yield missing
    if config.servo is not None:
        path = (Path() if file is None else file.parent) / config.servo.calibration
        try:
            load_calibration(path, config.rig.name, config.servo.servo_ids(len(config.rod.tendon_positions)))
        except TendondError as error:
            yield str(error)


def _frame_key(config: RigConfig) -> str:
    """Return the key that decides on the period of the simulated camera."""
    if config.simulator.mocap.period:
        return " (simulator.mocap.period)"
    return f" (simulator.period{', by default' if by_default(config.simulator, 'period') else ''})"


def reference_remarks(config: RigConfig) -> Iterator[str]:
    """Yield what the controller says of its reference at the start: another shape than expected, strain, a late tip."""
    from tendond.daemon.control.setup import CycleSetup
    from tendond.model import ModelError

    with suppress(DaemonError, ModelError):  # is an error of its own
        yield from CycleSetup.from_config(config).selection.reference.notes


def safety_remarks(config: RigConfig) -> Iterator[str]:
    """Compare the target with [safety]; a message where the filter does not let the tip go there."""
    from tendond.daemon.control.safety.configured import target_remark
    from tendond.daemon.control.setup import CycleSetup
    from tendond.model import ModelError

    if config.safety is None:
        return
    with suppress(DaemonError, ModelError):  # is an error of its own
        setup = CycleSetup.from_config(config)
        if remark := target_remark(setup.barrier, setup.selection.reference.target):
            yield f"safety: {remark}"


def _swinging(config: RigConfig) -> Iterator[str]:
    """Say that a law which moves the tip within a cycle was chosen for a robot that may swing under it."""
    from tendond.daemon.control.laws import BENDING_PLANE

    law, why = LAWS.get(config.control.law), swings(config.rod, config.loop.period)
    if law is not None and law.task_space is BENDING_PLANE and why:
        yield (
            f"control.law: {law.name} may swing this arm at {1.0 / config.loop.period:g} Hz: {why}{_radius(config)}; "
            'control.law = "sensitivity" moves it along its rests'
        )


def _radius(config: RigConfig) -> str:
    """Say how fast motions about a rest grow in the configuration's loop; empty where that is not known."""
    from tendond.offline.stability.margins import own_loop

    with suppress(TendondError, TypeError):
        found = own_loop(config, CHECKED_BEND)
        if not found.stable and math.isfinite(found.radius):
            return (
                f"; bent by {CHECKED_BEND:g} degrees the loop is unstable: motions grow by a factor of "
                f"{found.radius:.3g} in each cycle (`tendond study stability -c` has its margins)"
            )
    return ""
