"""The general rod in strain coordinates: sections, routed tendons, bodies, light damping, consistent energy.

Sources: F. Boyer, V. Lebastard, F. Candelier, F. Renda, "Dynamics of continuum and soft robots: a strain
parameterization based approach", IEEE T-RO 37 (2021); F. Renda, C. Armanini, V. Lebastard, F. Candelier, F. Boyer, "A
geometric variable-strain approach for static modeling of soft manipulators with tendon and fluidic actuation",
IEEE RA-L 5 (2020); D. C. Rucker, R. J. Webster, "Statics and dynamics of continuum robots with general tendon routing
and external loading", IEEE T-RO 27 (2011).
"""

from tendond.model.strain.describe.base import Base
from tendond.model.strain.describe.section import Section
from tendond.model.strain.robot import Body, Robot, Tendon
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState

__all__ = ["Base", "Body", "Robot", "Section", "StrainRod", "StrainState", "Tendon"]
