"""A robot's shapes with tendons, bodies and strain: a figure, or an interactive view. Import only to draw."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from tendond.daemon.errors import UsageError
from tendond.model.strain.analysis.frames import frames, strength, tendon_path
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, style

Array = NDArray[np.float64]

AIR = 0.05
"""Margin about the robot, as a fraction of its length."""


def robot_figure(rod: StrainRod, states: StrainState | Sequence[StrainState] | None = None) -> Figure:
    """Draw shapes of a robot in space, and the strain of its outermost fibre along it.

    Args:
        rod: the robot.
        states: one, or several; default: the reference shape.
    """
    chosen = _listed(rod, states)
    with style():
        figure = Figure((10.0, 5.0), layout="constrained")
        space: Any = figure.add_subplot(1, 2, 1, projection="3d")
        along = figure.add_subplot(1, 2, 2)
        points = []
        for index, state in enumerate(chosen):
            shade = 1.0 if index == len(chosen) - 1 else 0.35
            backbone = 1e3 * frames(rod, state)[:, :3, 3]
            points.append(backbone)
            space.plot(*backbone.T, color=OURS, lw=2.5, alpha=shade, label="backbone" if shade == 1.0 else None)
            for number in range(len(rod.robot.tendons)):
                path = 1e3 * tendon_path(rod, state, number)
                points.append(path)
                label = "tendons" if shade == 1.0 and number == 0 else None
                space.plot(*path.T, color=REFERENCE, lw=0.8, alpha=shade, label=label)
            bodies = _bodies(rod, state)
            if len(bodies):
                points.append(1e3 * bodies)
                space.plot(*(1e3 * bodies).T, "o", color=PAPERS, ms=4, alpha=shade, ls="")
            found = strength(rod, state)
            along.plot(1e3 * found.s, 100.0 * found.strain, color=OURS, alpha=shade)
        low, high = np.vstack(points).min(axis=0), np.vstack(points).max(axis=0)
        # A box that is narrow on paper has no room for its ticks: no side is shorter than half of the longest.
        middle, sides = 0.5 * (low + high), high - low + 2.0 * 1e3 * AIR * rod.robot.length
        sides = np.maximum(sides, 0.5 * sides.max())
        for axis, centre, side in zip((space.xaxis, space.yaxis, space.zaxis), middle, sides, strict=True):
            axis.set_view_interval(centre - 0.5 * side, centre + 0.5 * side, ignore=True)
            axis.set_major_locator(MaxNLocator(4))
        space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
        space.set_box_aspect(sides, zoom=0.9)
        space.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
        along.set(xlabel="arc length [mm]", ylabel="strain of the outermost fibre [%]")
    return figure


def robot_view(rod: StrainRod, states: StrainState | Sequence[StrainState] | None = None) -> Any:
    """Return the same shapes as an interactive figure, with a slider through the states.

    A notebook shows it; `write_html(path)` makes a page of it.

    Raises:
        UsageError: plotly is not installed.
    """
    try:
        import plotly.graph_objects as go
    except ImportError as error:
        raise UsageError("an interactive view needs plotly: pip install 'tendond[plot]'") from error

    def traces(state: StrainState) -> list[Any]:
        gap = np.full((1, 3), np.nan)
        paths = [part for i in range(len(rod.robot.tendons)) for part in (tendon_path(rod, state, i), gap)]
        shown = {
            "backbone": (frames(rod, state)[:, :3, 3], {"mode": "lines", "line": {"color": OURS, "width": 8}}),
            "tendons": (np.vstack(paths or [gap]), {"mode": "lines", "line": {"color": REFERENCE, "width": 2}}),
            "bodies": (
                np.vstack([_bodies(rod, state), gap]),
                {"mode": "markers", "marker": {"color": PAPERS, "size": 4}},
            ),
        }
        return [
            go.Scatter3d(**dict(zip("xyz", (1e3 * points).T, strict=True)), name=name, **look)
            for name, (points, look) in shown.items()
        ]

    chosen = _listed(rod, states)
    moments = [go.Frame(name=str(index), data=traces(state)) for index, state in enumerate(chosen)]
    steps = [
        {"label": one.name, "method": "animate", "args": [[one.name], {"mode": "immediate", "frame": {"duration": 0}}]}
        for one in moments
    ]
    figure = go.Figure(data=traces(chosen[-1]), frames=moments)
    reach = 1e3 * rod.robot.length * (1.0 + AIR)
    x, y, z = 1e3 * np.array(rod.robot.origin)
    scene = {
        f"{letter}axis": {"title": f"{letter} [mm]", "range": [centre - reach, centre + reach]}
        for letter, centre in zip("xyz", (x, y, z), strict=True)
    }
    figure.update_layout(
        template="plotly_white", height=700, scene={**scene, "aspectmode": "cube"},
        sliders=[{"active": len(steps) - 1, "steps": steps, "currentvalue": {"prefix": "state "}}],
    )  # fmt: skip
    return figure


def _listed(rod: StrainRod, states: StrainState | Sequence[StrainState] | None) -> list[StrainState]:
    if states is None:
        return [rod.rest()]
    return [states] if isinstance(states, StrainState) else list(states)


def _bodies(rod: StrainRod, state: StrainState) -> Array:
    """Centres of mass of the bodies, world frame [m], shape (k, 3)."""
    bodies = [body for body in rod.robot.bodies if body.mass > 0.0]
    if not bodies:
        return np.zeros((0, 3))
    poses = frames(rod, state, [body.at for body in bodies])
    return np.array([pose[:3, :3] @ body.offset + pose[:3, 3] for pose, body in zip(poses, bodies, strict=True)])
