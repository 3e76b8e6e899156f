"""Materials of backbones by name, with typical values: a data sheet's are better."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """A material.

    Attributes:
        youngs_modulus: [Pa]. density: [kg/m^3]. poisson_ratio: [-].
        yield_strain: without a permanent bend, or a break [-].
        source: of the values.
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float
    yield_strain: float
    source: str


MATERIALS = {
    "spring-steel": Material(206e9, 7850.0, 0.3, 0.008, "EN 10270-1, music wire of 1 mm: 0.8 of its tensile strength"),
    "stainless-steel": Material(185e9, 7900.0, 0.3, 0.008, "EN 10270-3, 1.4310 of 1 mm: 0.8 of its tensile strength"),
    "nitinol": Material(54e9, 6450.0, 0.3, 0.06, "E of Rao et al. 2021; superelastic strain of ASTM F2516"),
    "glass-fibre": Material(40e9, 2000.0, 0.3, 0.01, "pultruded rod, half of its strain at break"),
    "carbon-fibre": Material(130e9, 1550.0, 0.3, 0.007, "pultruded rod, half of its strain at break"),
}
"""Materials by name."""
