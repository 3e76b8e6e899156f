"""`tendond simulate`: the simulated robot."""

from collections.abc import Mapping
from pathlib import Path

from pydantic import ValidationError

from tendond.cli.common import chosen_config, load_config, present, say, stop_on_signals
from tendond.daemon.errors import DaemonError
from tendond.daemon.runtime.realtime import keep_up
from tendond.drivers.dynamixel.calibration import load_calibration
from tendond.drivers.simulator.faults import request_fault
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.process import Simulator
from tendond.drivers.simulator.rods import ACCURACY, PLANTS, GeneralPlantRod, PlantRod, plant_rod
from tendond.drivers.wired.rig import WiredRig, without_servos
from tendond.model import ModelError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.progress import working
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.errors.explain import choose, explain
from tendond.schemas.faults import Fault, FaultRequest


def on_plant(config: RigConfig, plant: str | None) -> RigConfig:
    """Return the configuration with the solver of its plant that `--plant` names; none: as configured.

    Raises:
        ConfigError: no plant has that name.
    """
    if plant is None:
        return config
    if plant not in PLANTS:
        raise ConfigError(f"--plant {plant}: choose one of {', '.join(PLANTS)}")
    section = config.simulator.model_copy(update={"solver": plant})
    return config.model_copy(update={"simulator": section})


def run_wired(config_file: Path | None, plant_name: str | None = None) -> None:
    """Run the wired rig until a signal comes; see `tendond simulate --help`.

    Raises:
        TendondError: see `run_simulator`; or the configuration lacks what the drivers need, or the port is taken.
    """
    config = on_plant(load_config(config_file), plant_name)
    servo = present(config.servo, "servo", config_file)
    vicon = present(config.cameras, "vicon", config_file)
    if vicon.connection[0] != "vicon":
        raise ConfigError(f"mocap.system = '{vicon.connection[0]}': --wired emulates Tracker: set 'vicon' for it")
    folder = Path() if config_file is None else config_file.parent
    ids = servo.servo_ids(len(config.rod.tendon_positions))
    calibration = load_calibration(folder / servo.calibration, config.rig.name, ids)
    plant_config = without_servos(config)
    rod = _rod(plant_config, str(config_file))
    plant = Plant(plant_config, rod)
    keep_up(config.loop)
    rig = WiredRig(config, servo, vicon, calibration, plant, stop_on_signals())
    say(f"wired rig '{config.rig.name}': servos at {servo.port}, Tracker to UDP port {vicon.port}")
    try:
        rig.run()
    finally:
        rig.close()
        _report_error(rod)


def inject_fault(config_file: Path | None, fault: str, options: Mapping[str, object]) -> None:
    """Inject a fault into a running simulator; see `tendond rig inject --help`.

    Raises:
        TendondError: there is no such fault or servo, it takes no such option, or no simulator runs.
    """
    try:
        known = Fault(fault)
    except ValueError:
        raise ConfigError(f"'{fault}' is not a fault: {choose(fault, Fault)}") from None
    if known.value != fault:
        say(f"fault '{fault}' was renamed to '{known.value}': use that name")
    try:
        request = FaultRequest.model_validate({"fault": known.value, **options})
    except ValidationError as error:
        raise ConfigError("\n".join(explain(error, FaultRequest))) from error
    reply = request_fault(load_config(config_file), request)
    if not reply.done:
        raise DaemonError(reply.message)
    print(reply.message)


def run_simulator(
    config_file: Path | None, profile: str | None, *, lockstep: bool, cycles: int | None, plant: str | None = None
) -> None:
    """Run until a signal comes, or for a number of cycles; see `tendond simulate --help`.

    Raises:
        TendondError: the configuration cannot be used, there is no controller, or the plant has no solution.
    """
    config, source = chosen_config(config_file, profile)
    config = on_plant(config, plant)
    rod = _rod(config, source)
    simulator = Simulator(config, Plant(config, rod), stop_on_signals())
    say(f"simulating rig '{config.rig.name}' for the controller at {config.bus.endpoint}")
    if not lockstep:
        keep_up(config.loop)
    try:
        simulator.run(lockstep=lockstep, cycles=cycles)
    finally:
        if simulator.unreadable:
            say(f"{simulator.unreadable} commands were unreadable")
        _report_error(rod)


def _report_error(rod: PlantRod) -> None:
    """Print the estimated error of the simulated tip where it was large."""
    if isinstance(rod, GeneralPlantRod) and rod.error_max > ACCURACY * rod.parameters.length:
        say(
            f"the simulated tip was up to {1e3 * rod.error_max:.1f} mm from that of more modes and shorter steps, "
            "by estimate: lower simulator.period, or slow the commands down"
        )


def _rod(config: RigConfig, source: str) -> PlantRod:
    """Build the plant's rod, and load its kernels."""
    announce_compilation(say)
    try:
        with working(f"setting up the simulated rig '{config.rig.name}'"):
            rod = plant_rod(config.simulator, config.simulator.period)
            Plant(config, rod).step(None)  # before the first pose
        return rod
    except ModelError as error:
        where = "simulator." if str(error).startswith("rod.") else "simulator.rod: "
        if str(error).startswith("simulator."):
            where = ""
        raise ConfigError(f"{source}: {where}{error}") from error
