"""Designs of the robots in the public data sets, as their authors describe them."""

import math

import numpy as np

from tendond.offline.validation.rods.design import Design

THIRD = 2.0 * math.pi / 3.0


def armlab() -> Design:
    """ARM-Lab's section, which hangs along -y. Neither length nor radius are published: both are wide.

    The tendons turn clockwise seen from the base, by the directions in which the tip goes; the base's place is a
    length above where the tip is without a command. Started without its weight, a fit ends in a worse minimum.
    """
    up = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    start = {
        "length_0": 0.16, "radius": 0.0084, "spool": 1.69, "zero_0": 3e-3, "zero_1": 2.3e-3, "zero_2": -1.4e-3,
        "base_x": -0.057, "base_y": 0.041, "base_z": 0.256, "marker_y": -0.014, "marker_z": 0.025,
        "weight_y": -2.2, "tip_weight": 9.0, "axial_stiffness": 9.5, "tendon_stiffness": 1000.0,
        "radius_0": 1.05, "radius_1": 0.86, "radius_2": 1.085, "angle_0": 0.12, "angle_1": 0.05, "angle_2": -0.03,
    }  # fmt: skip
    return Design(
        lengths=(0.13,), ends=(0, 0, 0), angles=tuple(3.58 - THIRD * i for i in range(3)), radius=0.007, up=up,
        origin=(-0.045, -0.01, 0.274), spread=(0.2, 0.3), axial_stiffness=9.0, tendon_stiffness=300.0, start=start,
    )  # fmt: skip


def ftdcr_v4() -> Design:
    """The arm ftdcr_v4: lengths, radius and tendons' angles from the authors' configuration."""
    return _ftdcr((0.06, 0.0625, 0.064))


def ftdcr_v6() -> Design:
    """The arm ftdcr_v6."""
    return _ftdcr((0.1, 0.1, 0.022))


def _ftdcr(lengths: tuple[float, float, float]) -> Design:
    offsets = (-3.0337, -2.5175, -2.0112)
    angles = tuple(offsets[i // 3] + THIRD * (i % 3) for i in range(9))
    return Design(
        lengths=lengths, ends=tuple(i // 3 for i in range(9)), angles=angles, radius=0.0045, up=np.eye(3),
        origin=(0.0, 0.0, -0.006), spread=(0.03, 0.1), tendon_stiffness=10.0, axial_stiffness=300.0, marker=0.008,
    )  # fmt: skip


def straight(tendons: int, length: float, radius: float, origin: tuple[float, float, float]) -> Design:
    """One straight section along +z of the camera's frame, with tendons at equal angles, the first one at +x."""
    return Design(
        lengths=(length,), ends=(0,) * tendons, angles=tuple(2.0 * math.pi * i / tendons for i in range(tendons)),
        radius=radius, up=np.eye(3), origin=origin, spread=(0.1, 0.2),
    )  # fmt: skip
