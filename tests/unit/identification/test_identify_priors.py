"""What is known beforehand: read, weighed against the data, and said where it decides."""

from pathlib import Path

import pytest

from tendond.daemon.errors import UsageError
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.priors import Prior, parse_priors
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.results.report import report
from tests.unit.identification.recordings import POSES, TRUE, pulls_and_waits, recording


@pytest.fixture(scope="module")
def waiting() -> Recording:
    return recording(moved=pulls_and_waits(POSES))


def test_priors_are_read_from_options_and_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "known.toml").write_text("tip_mass = [0.02, 0.001]\n[rod]\ndensity = [18000.0, 200]\n")
    found = parse_priors(["rod.youngs_modulus=1.9e11+-2e9", str(tmp_path / "known.toml"), "mu=0.1 +- 0.05"])
    assert found == {
        "E": Prior(1.9e11, 2e9), "tip_mass": Prior(0.02, 1e-3), "rho": Prior(18000.0, 200.0), "mu": Prior(0.1, 0.05),
    }  # fmt: skip
    assert set(parse_priors(["precurvature=0+-0.1"])) == {"precurvature_x", "precurvature_y"}


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("mass=1+-2", "'mass' is no parameter: choose among E, rho, Bbt"),
        ("rho=18000", "give KEY=VALUE.-SIGMA"),
        ("rho=18000+-0", "the sigma must be finite and above 0"),
        ("rho=18000+-nan", "the sigma must be finite and above 0"),
        ("missing.toml", "is neither a file of priors"),
    ],
)
def test_a_wrong_prior_is_refused_in_one_line(option: str, said: str) -> None:
    with pytest.raises(UsageError, match=said) as caught:
        parse_priors([option])
    assert "\n" not in str(caught.value)


def test_a_prior_of_a_force_fixes_the_scale_and_has_its_own_error(waiting: Recording) -> None:
    """Rests fix only ratios: the relative error of the density is that of its prior, and E has it as well."""
    prior = Prior(TRUE["rho"], 0.02 * TRUE["rho"])
    result = identify([waiting], [], Options(("E", "rho", "tendon_stiffness"), priors={"rho": prior}))
    found = {one.parameter.name: one for one in result.parameters}
    assert result.scale == "the prior of rho"
    assert found["rho"].value == pytest.approx(TRUE["rho"], rel=1e-3)
    assert found["rho"].error / found["rho"].value == pytest.approx(0.02, rel=0.02)
    assert found["E"].error / found["E"].value == pytest.approx(0.02, rel=0.05)
    assert (found["rho"].decided, found["E"].decided) == ("prior", "")
    assert "decided by the prior" in report(result, "identified.toml")


def test_data_overrule_a_wide_prior_and_a_narrow_one_overrules_them(waiting: Recording) -> None:
    """In the limit of a wide prior the fit is that without; in that of a narrow one the value is the prior's."""
    names = ("tendon_stiffness",)
    plain = identify([waiting], [], Options(names)).values["tendon_stiffness"]
    off = 1.05 * plain
    wide, narrow = (
        identify([waiting], [], Options(names, priors={"tendon_stiffness": Prior(off, sigma)})).parameters[0]
        for sigma in (0.5 * off, 1e-6 * off)
    )
    assert wide.value == pytest.approx(plain, rel=1e-4)
    assert wide.decided == "data"
    assert narrow.value == pytest.approx(off, rel=1e-3)
    assert narrow.decided == "prior"
