"""Constant curvature: each section an arc, its tendons springs that can be slack.

The bend of a section is a vector b [rad], towards which it bends, and a tendon at the angle a and the radius r shortens
by r b . (cos a, sin a) (R. J. Webster, B. A. Jones, "Design and kinematic modeling of constant curvature continuum
robots: a review", IJRR 29, 2010). The bends are the minimum of sum |b|^2 EI/L / 2 + k sum max(0, c - d)^2 / 2.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.offline.validation.rods.design import Design

Array = NDArray[np.float64]

NEWTON = 30
"""Largest number of active-set iterations: each tendon turns slack or taut a few times at most."""


def bends(design: Design, values: dict[str, float], command: Array) -> Array:
    """Return the bend of each section towards x and y [rad], shape (N, S, 2)."""
    sections = len(design.lengths)
    lengths = [values[f"length_{i}"] for i in range(sections)]
    pulls = np.zeros((design_tendons(design), 2 * sections))
    zeros = np.array([values[f"zero_{i}"] for i in range(len(pulls))])
    for i, (end, angle) in enumerate(zip(design.ends, design.angles, strict=True)):
        turn = angle + values[f"angle_{i}"]
        for section in range(end + 1):
            pulls[i, 2 * section : 2 * section + 2] = values["radius"] * np.cos(turn), values["radius"] * np.sin(turn)
    stiffness = values["tendon_stiffness"] / (values["radius"] ** 2 * sum(lengths))
    own = np.diag(np.repeat(1.0 / np.array(lengths), 2))
    aims = command - zeros
    found = np.zeros((len(command), 2 * sections))
    taut = aims > 0.0
    for _ in range(NEWTON):
        active = np.where(taut, stiffness, 0.0)
        matrix = own + np.einsum("ni,ia,ib->nab", active, pulls, pulls)
        found = np.linalg.solve(matrix, ((active * aims) @ pulls)[..., None])[..., 0]
        now = aims > found @ pulls.T
        if np.array_equal(now, taut):
            break
        taut = now
    return found.reshape(len(command), sections, 2)


def design_tendons(design: Design) -> int:
    """Return the number of tendons."""
    return len(design.ends)


def predict_arcs(design: Design, values: dict[str, float], command: Array) -> Array:
    """Return the marker's position for commands [m], camera's frame [m], shape (N, 3)."""
    bend = bends(design, values, command)
    turned = Rotation.from_rotvec([values[f"base_turn_{axis}"] for axis in "xyz"]).as_matrix()
    frame = np.broadcast_to(design.up @ turned, (len(command), 3, 3))
    place = np.tile([values["base_x"], values["base_y"], values["base_z"]], (len(command), 1))
    for section in range(len(design.lengths)):
        length = values[f"length_{section}"]
        x, y = bend[:, section, 0], bend[:, section, 1]
        angle = np.hypot(x, y)
        small = np.maximum(angle, 1e-9)
        across = np.where(angle > 1e-6, (1.0 - np.cos(small)) / small**2, 0.5)
        along = np.where(angle > 1e-6, np.sin(small) / small, 1.0)
        arc = length * np.stack([across * x, across * y, along], axis=1)
        place = place + np.einsum("nab,nb->na", frame, arc)
        frame = frame @ Rotation.from_rotvec(np.stack([-y, x, np.zeros_like(x)], axis=1)).as_matrix()
    marker = np.array([values[f"marker_{axis}"] for axis in "xyz"])
    return np.asarray(place + frame @ marker)
