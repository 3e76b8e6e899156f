"""`tendond config`: check, show, schema."""

import json
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from tendond import TendondError
from tendond.cli.common import chosen_config, say
from tendond.cli.manual.config_text import config_schema, config_toml
from tendond.daemon.control.laws import LAWS, select_law
from tendond.daemon.errors import DaemonError, LawError
from tendond.model.numerics.announce import announce_compilation
from tendond.schemas.config.control import ControlSection
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.errors.explain import Objection, dotted, in_file, objection_from
from tendond.schemas.errors.toml_lines import key_lines, line_of

INCOMPLETE = "what depends on several keys is looked at once these are mended"


def run_check(file: Path | None, profile: str | None, *, as_json: bool, model: bool = True) -> None:
    """Print everything that is wrong; see `tendond config check --help`.

    Args:
        file: of the configuration.
        profile: instead of it.
        as_json: for programs.
        model: look with the rod's model, too; its kernels may have to be compiled.

    Raises:
        ConfigError: something is, and text is wanted.
        SystemExit: with 2, something is, and JSON is wanted.
    """
    notes: list[str] = []
    try:
        config, source = chosen_config(file, profile)
    except ConfigError as error:
        wrong, source, text = list(error.objections), str(file or profile), str(error)
        if wrong:
            wrong += _located(_law_objections(_control_of(file)), file)
            wrong.sort(key=lambda one: one.line or 0)
            text = "\n".join(in_file(one, source) for one in wrong)
            notes.append(INCOMPLETE)
        else:
            wrong = [Objection("", "", text)]
    else:
        wrong = _located([*_law_objections(config.control), *(_start_objections(config) if model else ())], file)
        text = "\n".join(in_file(one, source) for one in wrong)
        notes += _notes(config, file)
    if as_json:
        found = [
            {"line": one.line, "key": one.key or dotted(one.path), "value": one.value, "message": one.message}
            for one in wrong
        ]
        print(json.dumps({"source": source, "ok": not wrong, "errors": found, "notes": notes}, indent=2))
        if wrong:
            raise SystemExit(2)
        return
    if wrong:
        raise ConfigError("\n".join([text, *(f"note: {note}" for note in notes)]), wrong)
    print(f"{source}: nothing is wrong with it; {_summary(config)}")
    for note in notes:
        print(f"note: {note}")


def _located(lines: Iterable[str], file: Path | None) -> list[Objection]:
    """As objections, with the lines of the file that they are about."""
    places = {} if file is None else key_lines(file.read_text(encoding="utf-8-sig"))
    found = [objection_from(line) for line in lines]
    return [replace(one, line=line_of(one.path, places)) for one in found]


def _control_of(file: Path | None) -> ControlSection | None:
    """[control] of a file that has other faults, if it is sound by itself."""
    if file is None:
        return None
    try:
        return ControlSection.model_validate(tomllib.loads(file.read_text(encoding="utf-8-sig")).get("control", {}))
    except ValidationError:
        return None


def _law_objections(control: ControlSection | None) -> list[str]:
    """What is wrong with the law's name and with the laws' parameters."""
    try:
        if control is not None:
            select_law(control.law, control.laws)
    except LawError as error:
        return str(error).splitlines()
    return []


def _start_objections(config: RigConfig) -> Iterator[str]:
    """What else controller and simulator would refuse at their start, found as they find it; with any law."""
    from tendond.daemon.control.selection import tip_objection
    from tendond.daemon.control.state import CycleSetup, initial_state, rod_from_section
    from tendond.drivers.simulator.plant import Plant
    from tendond.model import ModelError

    announce_compilation(say)
    control = config.control.model_copy(update={"law": next(iter(LAWS)), "laws": {}})
    try:
        initial_state(CycleSetup.from_config(config.model_copy(update={"control": control})))
    except (DaemonError, ModelError) as error:
        yield from str(error).splitlines()
    law = LAWS.get(config.control.law)
    if law is not None and (objection := tip_objection(config, law)):
        yield objection
    try:
        Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))
    except ModelError as error:
        yield f"simulator.rod: {error}"


def _notes(config: RigConfig, file: Path | None) -> Iterator[str]:
    """What is not wrong with the configuration, but will keep a process from running as things stand."""
    from tendond.daemon.control.gains import lowered
    from tendond.daemon.control.state import rod_from_section
    from tendond.daemon.runtime.bus import hub_settings
    from tendond.drivers.dynamixel.calibration import load_calibration
    from tendond.drivers.vicon.datastream import is_installed

    try:
        hub_settings(config)
    except ConfigError as error:
        yield str(error)
    if gains := lowered(config, rod_from_section(config.rod, config.loop.period).parameters):
        yield gains
    frame, allowed = config.simulator.mocap.period or config.simulator.period, config.faults.pose_timeout
    if allowed < 2.0 * frame:
        yield (
            f"the simulated camera sends a pose each {frame * 1e3:g} ms, and faults.pose_timeout = "
            f"{allowed * 1e3:g} ms bears less than one lost frame: raise it, or lower simulator.mocap.period"
        )
    elif frame > 3.0 * config.loop.period:
        yield (
            f"the simulated camera sends a pose each {frame * 1e3:g} ms, the loop runs each "
            f"{config.loop.period * 1e3:g} ms: most cycles have no new pose and rest on the model"
        )
    if config.vicon is not None and config.vicon.source == "datastream" and not is_installed():
        yield "vicon.source = 'datastream' needs the motioncapture package: pip install 'tendond[vicon-sdk]'"
    if config.servo is not None:
        path = (Path() if file is None else file.parent) / config.servo.calibration
        try:
            load_calibration(path, config.rig.name, config.servo.servo_ids(len(config.rod.tendon_positions)))
        except TendondError as error:
            yield str(error)


def _summary(config: RigConfig) -> str:
    drivers = [name for name in ("vicon", "servo") if getattr(config, name) is not None]
    return (
        f"rig '{config.rig.name}', law {config.control.law}, {1.0 / config.loop.period:g} Hz, "
        f"{len(config.rod.tendon_positions)} tendons up to {config.limits.tension_max:g} N, "
        f"drivers {' and '.join(drivers) or 'none'}"
    )


def run_show(file: Path | None, profile: str | None, *, changed: bool, comments: bool, as_json: bool) -> None:
    """Print the configuration in effect; see `tendond config show --help`.

    Raises:
        ConfigError: it cannot be used.
    """
    config, _ = chosen_config(file, profile)
    if as_json:
        print(json.dumps(config.model_dump(mode="json", exclude_defaults=changed), indent=2))
    else:
        print(config_toml(config, changed=changed, comments=comments), end="")


def run_schema() -> None:
    """Print the JSON Schema."""
    print(json.dumps(config_schema(), indent=2))
