"""The equilibria of a target that `config check` lists."""

import math

import pytest

from tendond.offline.equilibria_check import equilibria, equilibrium_lines
from tendond.schemas.config.rig import check_config

WIRE = {"rod": {"preset": "nitinol"}, "limits": {"tension_max": 8.0}, "reference": {"across": 0.05}}


def test_the_least_bent_equilibrium_is_first_and_meant_and_stable() -> None:
    found = equilibria(check_config(WIRE, "test"))
    assert [one.number for one in found] == list(range(1, len(found) + 1))
    assert [one.target for one in found] == [index == 0 for index in range(len(found))]
    assert found[0].stability > 0.0
    assert found[0].margin == pytest.approx(8.0 - found[0].tension)
    # Constant curvature without weight: EI bend / L = T r, strain = radius bend / L.
    EI, bend = 54e9 * math.pi / 4.0 * 7e-4**4, found[0].bend
    assert found[0].tension * 0.01 == pytest.approx(EI * bend / 0.2, rel=0.15)
    assert found[0].strain == pytest.approx(7e-4 * bend / 0.2, rel=0.15)


def test_strain_beyond_what_the_wire_bears_is_said() -> None:
    soft = {**WIRE, "rod": {"preset": "nitinol", "yield_strain": 1e-4}}
    assert "beyond the 0.01 % that the wire bears" in next(equilibrium_lines(check_config(soft, "test")))
    assert "beyond" not in next(equilibrium_lines(check_config(WIRE, "test")))
