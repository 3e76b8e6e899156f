"""Candidates of `--parameters auto`: what a robot and its logs could show, in the order of preference."""

from collections.abc import Mapping, Sequence

from tendond.offline.identification.configured import absent, nominal, parameters_of
from tendond.offline.identification.fitting.candidate import ORDER, Candidate, Trial
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.parameters import chosen
from tendond.schemas.config.rig import RigConfig

HELD = "held: it fixes the scale of force, as no known weight, load or prior does"


def candidates(config: RigConfig, unseen: Mapping[str, str], known_force: bool) -> tuple[list[Candidate], list[Trial]]:
    """Return the candidates, and the outcome of those that cannot be.

    Args:
        config: of the rig. unseen: reasons of parameters that the logs do not show, by name.
        known_force: whether a weight, the servos' load or a prior fixes the scale of force.
    """
    found, refused = [], []
    for name in ORDER:
        parameters = parameters_of(config.rod, chosen([name]))
        why = {**absent(config, parameters), **unseen}
        if name == "rho" and not known_force:
            why[name] = HELD
        if reasons := [why[one.name] for one in parameters if one.name in why]:
            refused.append(Trial(name, 0.0, False, reasons[0]))
        elif reason := _no_start(config, parameters):
            refused.append(Trial(name, 0.0, False, reason))
        else:
            found.append(Candidate(name, parameters))
    return found, refused


def _no_start(config: RigConfig, parameters: Sequence[Parameter]) -> str:
    """Return the reason for which a factor cannot start: there is nothing that it multiplies."""
    values = nominal(config)
    missing = [one for one in parameters if one.logarithmic and values[one.name] <= 0.0]
    return f"{missing[0].section}.{missing[0].key} = 0: set a first guess" if missing else ""
