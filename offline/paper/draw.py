"""The list of figures, and drawing them in a pool. Import this module only to draw."""

from collections.abc import Callable
from concurrent.futures import Executor, as_completed
from functools import partial
from pathlib import Path

from tendond.offline.paper.figures import both_laws, experiment_curves, force_found, loaded, lyapunov, name_of
from tendond.offline.paper.published import LAWS
from tendond.offline.paper.run import Runs
from tendond.offline.paper.scenarios import HUNG_AT, STRING, WEIGHTS_G
from tendond.offline.paper.shapes import configurations, snapshots
from tendond.offline.plots.appearance import Appearance, appearance, appearing

Draw = Callable[[Runs, Path], Path]

EDGE_TITLE = "edge of stability"
SAME_TITLE = "same information"


def figures() -> dict[str, tuple[Draw, tuple[str, ...]]]:
    """Return each figure's drawing function and scenarios, by name."""
    found: dict[str, tuple[Draw, tuple[str, ...]]] = {}
    for suffix, title in (("", SAME_TITLE), ("_edge", EDGE_TITLE)):
        normal = f"normal{suffix}"
        found[normal] = (partial(both_laws, normal, f"Normal conditions, {title}"), (normal,))
        found[f"configurations{suffix}"] = (partial(configurations, normal, title.capitalize()), (normal,))
        for law in LAWS:
            weights = tuple((f"weight_{grams}g{suffix}", f"{grams} g") for grams in WEIGHTS_G)
            for name, loads, what in (
                (f"weights_{law}{suffix}", weights, "added weights"),
                (f"disturbance_{law}{suffix}", ((f"disturbance{suffix}", "10 N in x, -10 N in z"),), "disturbance"),
            ):
                heading = f"{name_of(law).capitalize()}, {what}, {title}"
                found[name] = (
                    partial(loaded, normal, loads, law, heading),
                    (normal, *(scenario for scenario, _ in loads)),
                )
    hanging = tuple((f"rig_weight_{grams}g", f"{grams} g") for grams in WEIGHTS_G)
    rows = (("rig_normal", "normal"), *hanging, ("rig_impacts", "impacts"))
    found["experiment_normal"] = (
        partial(both_laws, "rig_normal", "Rig-like plant, normal conditions"),
        ("rig_normal",),
    )
    found["experiment_normal_direct"] = (
        partial(both_laws, "rig_normal_direct", "Rig-like plant, laws fed with the measured velocity"),
        ("rig_normal_direct",),
    )
    found["experiment_weights"] = (
        partial(experiment_curves, hanging, f"Rig-like plant, weight on a string of {STRING:g} m"),
        tuple(name for name, _ in hanging),
    )
    found["experiment_impacts"] = (
        partial(experiment_curves, rows[-1:], "Rig-like plant, random impacts (dotted)"),
        ("rig_impacts",),
    )
    for law in LAWS:
        found[f"snapshots_{law}"] = (partial(snapshots, rows, law), tuple(name for name, _ in rows))
    hung = tuple((f"weight_{grams}g_found", f"{grams} g") for grams in WEIGHTS_G)
    found["force"] = (
        partial(force_found, hung, f"A weight hung on at iteration {HUNG_AT}, and the observer's estimate"),
        tuple(name for name, _ in hung),
    )
    values = (("normal", SAME_TITLE), ("normal_edge", EDGE_TITLE))
    found["lyapunov"] = (partial(lyapunov, values), tuple(name for name, _ in values))
    return found


def draw_all(runs: Runs, folder: Path, pool: Executor, done: Callable[[str], None]) -> list[Path]:
    """Draw the figures into the existing `folder`, in `pool`; `done` is called with the name of each.

    They have the appearance in use, and a file in each of its formats; the first ones are returned.
    """
    look = appearance()
    futures = {}
    for name, (draw, scenarios) in figures().items():
        needed = {key: run for key, run in runs.items() if key[0] in scenarios}
        futures[pool.submit(_drawn, look, draw, needed, folder / f"{name}.png")] = name
    for future in as_completed(futures):
        future.result()
        done(futures[future])
    return [future.result() for future in futures]


def _drawn(look: Appearance, draw: Draw, runs: Runs, path: Path) -> Path:
    """Draw a figure in a process of the pool, in an appearance."""
    with appearing(look):
        return draw(runs, path)
