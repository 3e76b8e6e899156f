"""`tendond simulate`: the simulated robot."""

from pathlib import Path

from tendond.daemon.cli.common import load_config, say, stop_on_signals
from tendond.daemon.state import rod_from_section
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.process import Simulator
from tendond.model import ModelError
from tendond.model.announce import announce_compilation
from tendond.schemas.config import ConfigError


def run_simulator(config_file: Path | None, *, lockstep: bool, cycles: int | None) -> None:
    """Run until a signal comes, or for so many cycles; see `tendond simulate --help`.

    Raises:
        TendondError: the configuration cannot be used, there is no controller, or the plant has no solution.
    """
    config = load_config(config_file)
    announce_compilation(say)
    try:
        rod = rod_from_section(config.simulator.rod, config.simulator.period)
        Plant(config, rod).step(None)  # for practice: the kernels are loaded before the first pose
        plant = Plant(config, rod)
    except ModelError as error:
        raise ConfigError(f"{config_file or 'built-in configuration'}: simulator.rod: {error}") from error
    simulator = Simulator(config, plant, stop_on_signals())
    say(f"simulating rig '{config.rig.name}' for the controller at {config.bus.endpoint}")
    simulator.run(lockstep=lockstep, cycles=cycles)
    if simulator.unreadable:
        say(f"{simulator.unreadable} commands could not be used")
