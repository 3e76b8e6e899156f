"""deploy/rig.toml: every key, in step with the schema, and meaning nothing but the defaults."""

import re
import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from tendond.cli.manual.annotate import annotated
from tendond.daemon.control.laws import LAWS
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.config.simulator import Impact
from tendond.schemas.config.vicon import ViconSection

EXAMPLE = Path(__file__).parents[3] / "deploy" / "rig.toml"


def switched_on() -> dict[str, Any]:
    """The example with everything that is commented out, but for keys that have no value."""
    lines = [re.sub(r"^#(?=[a-z\[])", "", line) for line in annotated().splitlines()]
    return tomllib.loads("\n".join(line for line in lines if not line.endswith("= ...")))


def test_the_example_is_what_the_schema_makes() -> None:
    assert EXAMPLE.read_text() == annotated(), "run `make example`"


def test_the_example_parses_to_the_defaults() -> None:
    assert parse_config(EXAMPLE.read_text(), "rig.toml") == RigConfig()


def test_what_is_commented_out_are_defaults_too() -> None:
    everything = switched_on()
    assert ServoSection.model_validate(everything["servo"]) == ServoSection()
    assert ViconSection.model_validate(everything["vicon"]) == ViconSection()
    for name, law in LAWS.items():
        assert law.parameters.model_validate(everything["control"]["laws"][name]) == law.parameters()


def test_every_key_is_there_with_its_range_or_meaning() -> None:
    lines = annotated().splitlines()

    def keys(model: type[BaseModel]) -> None:
        for key, field in model.model_fields.items():
            found = [i for i, line in enumerate(lines) if re.match(rf"#?(\[+([a-z_]+\.)*{key}\]+$|{key} = )", line)]
            assert found or key == "laws", f"{model.__name__}.{key}"
            if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
                keys(field.annotation)

    for model in (RigConfig, ServoSection, ViconSection, Impact):
        keys(model)
    for number, line in enumerate(lines):
        if re.match(r"#?[a-z_0-9]+ = ", line):
            assert lines[number - 1].startswith("# "), f"nothing is said of {line}"
