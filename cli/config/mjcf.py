"""`tendond config mjcf`: the simulated robot as MuJoCo reads it."""

from pathlib import Path

from tendond.cli.common import chosen_config, say
from tendond.cli.extras import need
from tendond.daemon.errors import DaemonError
from tendond.drivers.mujoco.mjcf import mjcf
from tendond.model.errors import ModelError
from tendond.schemas.config.rig import ConfigError


def run_mjcf(file: Path | None, profile: str | None, out: Path | None, *, force: bool) -> None:
    """Write the robot of [simulator.rod], or print it; see `tendond config mjcf --help`.

    Raises:
        ConfigError: the configuration cannot be used, or a chain of joints cannot be that robot.
        DaemonError: the file cannot be written, or is there already.
    """
    need("mujoco")  # which finds the largest stable step
    from tendond.drivers.simulator.mujoco_rod import MujocoRod

    config, source = chosen_config(file, profile)
    try:
        chain = MujocoRod(config.simulator, config.simulator.period).chain
    except ModelError as error:
        where = "simulator." if str(error).startswith("rod.") else ""
        raise ConfigError(f"{source}: {where}{error}") from error
    text = mjcf(chain)
    if out is None:
        print(text, end="")
        return
    try:
        with out.open("w" if force else "x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise DaemonError(f"{out}: is there already; give another --out, or --force to replace it") from None
    except OSError as error:
        raise DaemonError(f"{out}: {error.strerror}; give another --out") from error
    say(f"{out}: {len(chain.links)} links, {len(chain.tendons)} tendons; drag is not in it, MJCF has no such")
