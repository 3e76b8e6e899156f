"""`tendond config`: check, show, schema."""

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from tendond import TendondError
from tendond.cli.common import chosen_config, say
from tendond.cli.manual.config_text import config_schema, config_toml
from tendond.model.errors import ModelError
from tendond.model.rods.selection import solver_of
from tendond.offline.config_check import (
    control_of,
    law_objections,
    located,
    reference_remarks,
    remarks,
    resolution_remarks,
    safety_remarks,
    start_objections,
)
from tendond.offline.cycle_time import cycle_lines
from tendond.offline.equilibria_check import equilibrium_lines
from tendond.offline.progress import working
from tendond.offline.robot_check import RobotReport, robot_report
from tendond.schemas.config.migration.version import CONFIG_VERSION, KEY
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.config.rod.presets import PRESETS
from tendond.schemas.errors.explain import Objection, choose, dotted, in_file

INCOMPLETE = "cross-key checks run after these are fixed"


def run_check(file: Path | None, profile: str | None, *, as_json: bool, model: bool = True) -> None:
    """Print every error; see `tendond config check --help`.

    Args:
        file: rig configuration, TOML.
        profile: built-in configuration to check instead.
        as_json: print JSON.
        model: check with the rod model as well; its kernels may have to be compiled.

    Raises:
        ConfigError: there are errors, and text is wanted.
        SystemExit: with 2, there are errors, and JSON is wanted.
    """
    notes: list[str] = []
    robot: RobotReport | None = None
    rests: list[str] = []
    try:
        config, source = chosen_config(file, profile)
    except ConfigError as error:
        wrong, source, text = list(error.objections), str(file or profile), str(error)
        if wrong:
            wrong += located(law_objections(control_of(file)), file)
            wrong.sort(key=lambda one: one.line or 0)
            text = "\n".join(in_file(one, source) for one in wrong)
            notes.append(INCOMPLETE)
        else:
            wrong = [Objection("", "", text)]
    else:
        with working(f"setting up {source}", quiet=as_json):
            refused = list(start_objections(config, say)) if model else []
        wrong = located([*law_objections(config.control), *refused], file)
        text = "\n".join(in_file(one, source) for one in wrong)
        notes += remarks(config, file)
        if model and not wrong:
            with working(f"running {source} on its simulator", quiet=as_json):
                notes += [*reference_remarks(config), *resolution_remarks(config), *safety_remarks(config)]
                rests = list(equilibrium_lines(config))
                said, remark = _cycle(config)
            rests += filter(None, [said])
            notes += filter(None, [remark])
        if model:
            robot, no_figures = _robot(config)
            notes += robot.notes if robot else (no_figures,)  # what runs is no error for want of figures
    if as_json:
        found = [
            {"line": one.line, "key": one.key or dotted(one.path), "value": one.value, "message": one.message}
            for one in wrong
        ]
        data = {"source": source, "ok": not wrong, "errors": found, "notes": notes}
        print(json.dumps(data | ({"robot": robot.data, "equilibria": rests} if robot else {}), indent=2))
        if wrong:
            raise SystemExit(2)
        return
    for line in robot.lines if wrong and robot else ():
        print(line)
    if wrong:
        raise ConfigError("\n".join([text, *(f"note: {note}" for note in notes)]), wrong)
    print(f"{source}: OK; {_summary(config)}")
    for line in [*(robot.lines if robot else ()), *rests]:
        print(line)
    for note in notes:
        print(f"note: {note}")


def _cycle(config: RigConfig) -> tuple[str, str]:
    """What a cycle takes on the general rod, whose laws may need too much of it; see `cycle_lines`."""
    if solver_of(config.rod, config.control.solver) == "shooting":
        return "", ""
    with suppress(TendondError):  # is an error of its own
        return cycle_lines(config)
    return "", ""


def _robot(config: RigConfig) -> tuple[RobotReport | None, str]:
    """Figures of the robot, or why it has none."""
    try:
        return robot_report(config), ""
    except ModelError as error:
        return None, f"rod: no figures of the robot: {error}"


def _summary(config: RigConfig) -> str:
    drivers = [name for name in ("vicon", "mocap", "servo") if getattr(config, name) is not None]
    return (
        f"rig '{config.rig.name}', law {config.control.law}, {1.0 / config.loop.period:g} Hz, "
        f"{len(config.rod.tendon_positions)} tendons up to {config.limits.tension_max:g} N, "
        f"drivers {' and '.join(drivers) or 'none'}"
    )


def run_show(file: Path | None, profile: str | None, *, changed: bool, comments: bool, as_json: bool) -> None:
    """Print the effective configuration; see `tendond config show --help`.

    Raises:
        ConfigError: it cannot be used.
    """
    config, _ = chosen_config(file, profile)
    if as_json:
        print(json.dumps(_changes(config) if changed else config.model_dump(mode="json"), indent=2))
    else:
        print(f"{KEY} = {CONFIG_VERSION}\n")
        print(config_toml(config, changed=changed, comments=comments), end="")


def run_preset(name: str, *, comments: bool, as_json: bool) -> None:
    """Print the tables of a robot by name; see `tendond config show --help`.

    Raises:
        ConfigError: there is no such preset.
    """
    if name not in PRESETS:
        raise ConfigError(f"unknown preset '{name}': {choose(name, PRESETS)}")
    config = check_config({"rod": PRESETS[name]}, f"preset '{name}'")
    if as_json:
        print(json.dumps(_changes(config), indent=2))
    else:
        print(config_toml(config, changed=True, comments=comments), end="")


def _changes(config: RigConfig) -> dict[str, Any]:
    """Return what differs from the defaults; of [simulator.rod], what differs from [rod]."""
    data: dict[str, Any] = config.model_dump(mode="json", exclude_defaults=True)
    model, plant = (one.model_dump(mode="json") for one in (config.rod, config.simulator.rod))
    own = {key: value for key, value in plant.items() if model.get(key) != value}
    simulator = {key: value for key, value in data.pop("simulator", {}).items() if key != "rod"}
    simulator |= {"rod": own} if own else {}
    return data | ({"simulator": simulator} if simulator else {})


def run_schema() -> None:
    """Print the JSON Schema."""
    print(json.dumps(config_schema(), indent=2))
