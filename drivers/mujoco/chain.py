"""A clamped rod as a chain of rigid links on ball joints, with tendons through sites: the description of a plant.

A rod of length L is N ball joints at (i + 1/2) L/N with rigid links between them. A joint stands for h = L/N of rod:
its stiffness is EI/h, its damping Bbt/h (moment = EI u + Bbt u_t). Torsion is as stiff as bending: a ball joint of
MuJoCo has one stiffness. The rod neither stretches nor shears.
"""

from collections.abc import Callable
from dataclasses import dataclass

Triple = tuple[float, float, float]
Place = tuple[float, float]

SITE_GAP = 0.25
"""Distance g of a tendon's sites from the joint, as a part of a link h. A bend of a joint shortens a tendon of radius r
by r + g h / 2 times the bend per radian, nearly; from 2 g h / r on (0.42 rad) the sites would pass each other."""


@dataclass(frozen=True)
class Link:
    """A joint, and the rod per length about it.

    Attributes:
        bending_stiffness: EI [N m^2]. damping: Bbt of bending [N m^2 s].
        mass_per_length: [kg/m]. section_inertia: per length about a diameter [kg m]. drag: C, body frame [kg/m^2].
    """

    bending_stiffness: float
    damping: float
    mass_per_length: float
    section_inertia: float
    drag: Triple


@dataclass(frozen=True)
class Path:
    """A tendon's path.

    Attributes:
        at: (x, y) in the cross-section [m] at an arc length [m].
        end: arc length at which it is fixed [m].
        stiffness: force per stretch of the whole tendon on a winch [N/m].
        holes: arc lengths at which alone it is guided [m]; none: all along the rod.
    """

    at: Callable[[float], Place]
    end: float
    stiffness: float
    holes: tuple[float, ...] = ()


@dataclass(frozen=True)
class Weight:
    """A rigid body on the rod.

    Attributes:
        at: arc length [m]. mass: [kg]. inertia: diagonal about its centre of mass, body frame [kg m^2].
        offset: from the rod to its centre of mass, body frame [m].
    """

    at: float
    mass: float
    inertia: Triple = (0.0, 0.0, 0.0)
    offset: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Chain:
    """A robot.

    Attributes:
        length: of the rod [m]. links: from the base to the tip. tendons: in the order of their tensions.
        weights: bodies on the rod. gravity: base's frame, the straight robot along +z [m/s^2].
        step: time step of the integrator [s].
    """

    length: float
    links: tuple[Link, ...]
    tendons: tuple[Path, ...]
    weights: tuple[Weight, ...] = ()
    gravity: Triple = (0.0, 0.0, 0.0)
    step: float = 1e-3

    @property
    def spacing(self) -> float:
        """Length of rod for which a joint stands, h [m]."""
        return self.length / len(self.links)

    def owner(self, s: float) -> int:
        """Return the link that carries the arc length s [m]; -1: the base, before the first joint."""
        return min(int(s / self.spacing + 0.5), len(self.links)) - 1

    def begin(self, link: int) -> float:
        """Return the arc length at which a link begins, at its joint [m]; that of the base is 0."""
        return 0.0 if link < 0 else (link + 0.5) * self.spacing

    def reach(self, link: int) -> float:
        """Return the length of a link [m]: half of one for the last."""
        return self.spacing * (0.5 if link == len(self.links) - 1 else 1.0)

    def sites(self, tendon: Path) -> list[float]:
        """Return the arc lengths of a tendon's sites [m], from the base to its end."""
        if tendon.holes:
            return [0.0, *(s for s in tendon.holes if s < tendon.end), tendon.end]
        h = self.spacing
        found = [0.0]
        for link in range(len(self.links)):
            joint = self.begin(link)
            found += [joint - SITE_GAP * h, joint + SITE_GAP * h]
        return [*(s for s in found if s < tendon.end * (1.0 - 1e-9)), tendon.end]
