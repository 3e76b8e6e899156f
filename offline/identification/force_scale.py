"""The scale of force that a set of recordings fixes, or does not."""

from collections.abc import Sequence

from tendond.offline.identification.configured import nominal, parameters_of
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.parameters import PARAMETERS
from tendond.offline.identification.recordings.recording import Recording


def force_scale(recordings: Sequence[Recording], parameters: Sequence[Parameter], options: Options) -> tuple[str, bool]:
    """Describe the source of the scale of force; return with it whether there is one."""
    names = {parameter.name for parameter in parameters}
    forces = [parameter.name for parameter in parameters if parameter.force]
    weights = sorted({recording.weight for recording in recordings if recording.weight > 0.0})
    if not forces:
        return "not needed: no requested parameter depends on it", True
    if weights:
        shown = ", ".join(f"{weight * 1e3:g} g" for weight in weights)
        return f"the known weight on the tip: {shown}", True
    if options.load_noise is not None:
        return (
            f"the servos' load, assumed to be accurate to {options.load_noise:g} N; an error of its scale is one of E",
            True,
        )
    known = [parameter.name for parameter in parameters if parameter.force and parameter.name in options.priors]
    if known:
        return f"the prior of {', '.join(known)}", True
    values = nominal(recordings[0].config)
    for held in ("rho", "E", "tip_mass"):
        if held not in names and values[held] > 0.0:
            (used,) = parameters_of(recordings[0].config.rod, (PARAMETERS[held],))
            at = f"{used.section}.{used.key} = {values[held]:g}"
            return f"{held}, which is not fitted: all others are relative to {at}", True
    return (
        "nothing: displacements and poses fix only ratios of E, rho, Bbt, C, tendon_stiffness and tip_mass. Record a "
        "log with a known weight on the tip ('tendond identify run --weight 0.05'), use the servos' load (--load 2), "
        "or do not fit a parameter that you have measured otherwise (rho, by weighing)",
        False,
    )


def weight_hides_tip_mass(recordings: Sequence[Recording], parameters: Sequence[Parameter], options: Options) -> bool:
    """Check for a weight that alone fixes the scale of force, in every log: then the tip mass is not identifiable."""
    names = {parameter.name for parameter in parameters}
    alone = options.load_noise is None and {"E", "rho", "tip_mass"} <= names
    return alone and recordings[0].weight > 0.0 and len({recording.weight for recording in recordings}) == 1
