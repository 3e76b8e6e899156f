"""`tendond simulate`: the simulated robot."""

from pathlib import Path

from tendond.daemon.cli.common import load_config, say, stop_on_signals
from tendond.daemon.state import rod_from_section
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.process import Simulator
from tendond.model.announce import announce_compilation


def run_simulator(config_file: Path | None, *, lockstep: bool, cycles: int | None) -> None:
    """Run until a signal comes, or for so many cycles; see `tendond simulate --help`.

    Raises:
        TendondError: the configuration cannot be used, there is no controller, or the plant has no solution.
    """
    config = load_config(config_file)
    stopped = stop_on_signals()
    announce_compilation(say)
    rod = rod_from_section(config.simulator.rod, config.simulator.period)
    Plant(config, rod).step(None)  # for practice: the kernels are loaded before the first pose
    simulator = Simulator(config, Plant(config, rod), stopped)
    say(f"simulating rig '{config.rig.name}' for the controller at {config.bus.endpoint}")
    simulator.run(lockstep=lockstep, cycles=cycles)
