"""Control laws: each a file of its own and a line in `LAWS`."""

from collections.abc import Mapping

from pydantic import ValidationError

from tendond.daemon.control.laws import backstepping, sensitivity, sliding_mode
from tendond.daemon.control.laws.law import Law, LawParameters
from tendond.daemon.errors import LawError
from tendond.schemas.errors.explain import explain

__all__ = ["LAWS", "Law", "LawParameters", "select_law"]

LAWS: dict[str, Law] = {
    backstepping.LAW.name: backstepping.LAW,
    sliding_mode.LAW.name: sliding_mode.LAW,
    sensitivity.LAW.name: sensitivity.LAW,
}


def select_law(name: str, tables: Mapping[str, Mapping[str, float]]) -> tuple[Law, LawParameters]:
    """The law of that name and its parameters; every table is checked, not only the selected law's.

    Args:
        name: of a law.
        tables: `control.laws` of the configuration: parameters by law.

    Raises:
        LawError: no such law, an unknown parameter, or a value out of range.
    """
    parameters, wrong = {}, []
    for key in dict.fromkeys([name, *tables]):
        if key not in LAWS:
            where = "control.law" if key == name else "control.laws"
            wrong.append(f"{where}: no law is called '{key}'; choose one of {', '.join(LAWS)}")
            continue
        try:
            parameters[key] = LAWS[key].parameters.model_validate(tables.get(key, {}))
        except ValidationError as error:
            wrong += [f"control.laws.{key}.{line}" for line in explain(error, LAWS[key].parameters)]
    if wrong:
        raise LawError("\n".join(wrong))
    return LAWS[name], parameters[name]
