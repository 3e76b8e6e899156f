"""Paragraphs of the page about the runs, with their numbers."""

import numpy as np

from tendond.offline.paper.edge import EDGE
from tendond.offline.paper.facts import deviation, gains, tpl
from tendond.offline.paper.lyapunov import along_share, find_rises
from tendond.offline.paper.published import LAWS, SIMULATION
from tendond.offline.paper.rig_account import rig_load_paragraphs, rig_paragraphs
from tendond.offline.paper.run import Runs
from tendond.offline.paper.scenarios import DISTURBANCE, DISTURBANCE_CYCLES, DISTURBED_AT, HUNG_AT, WEIGHTS_G

BACK, SLIDE = LAWS


FOUND = 0.1
"""An estimated force within this part of the true one has converged."""


ALIKE = 0.02
"""Path lengths that differ by less than this part count as equal."""


def account(runs: Runs, topic: str) -> str:
    """Write a paragraph or more on a topic."""
    return "\n\n".join(_TOPICS[topic](runs))


def _edge(runs: Runs) -> list[str]:
    halves = {law: (tpl(runs["normal_edge", law], 100), runs["normal_edge", law].metrics.tpl_mm) for law in LAWS}
    count = len(runs["normal_edge", SLIDE].tip)
    neighbours = {law: [run.metrics for (name, one), run in runs.items() if one == law and name.startswith("edge_near")]
            for law in LAWS}  # fmt: skip
    spread = {law: (min(m.tpl_mm for m in neighbours[law]), max(m.tpl_mm for m in neighbours[law])) for law in LAWS}
    settled = sorted(m.settling_iterations if m.settling_iterations is not None else count for m in neighbours[SLIDE])
    return [
        "One condition for both laws: the velocity is taken from differences of the measured tip "
        '(`control.feedback = "direct"`), an antagonist pair pulls (`control.antagonist = 2`, up to '
        f"{EDGE['tension_max']:g} N each, pretension {EDGE['pretension']:g} N), and the controller's model is not "
        f"the plant: E x {EDGE['youngs_modulus']:g}, rho x {EDGE['density']:g}, Bbt x {EDGE['bending_damping']:g}; the "
        "target is (340, 0) mm, as the paper writes it, so that x rests short of 340 mm. "
        "These five numbers were fitted to the paper's two rows by an optimiser: the paper names "
        "no such condition. It is one under which the paper's numbers arise, not necessarily the paper's.",
        f"Sensitivity: with one of the five numbers changed by 2 % at a time, TPL is {spread[BACK][0]:.0f} "
        f"to {spread[BACK][1]:.0f} mm for backstepping and {spread[SLIDE][0]:.0f} to {spread[SLIDE][1]:.0f} mm for "
        f"sliding mode, whose settling is {settled[0]} to {settled[-1]} iterations: the order of magnitude is the "
        "condition's, the last digits are a result of the fit.",
        "The path of an oscillating tip grows with the length of the run, which the paper does not give: "
        f"in the first 100 iterations TPL is {halves[BACK][0]:.0f} mm (backstepping) and {halves[SLIDE][0]:.0f} mm "
        f"(sliding mode), in all {count} it is {halves[BACK][1]:.0f} and {halves[SLIDE][1]:.0f} mm. In the last 40 the "
        f"tip still oscillates by {runs['normal_edge', BACK].metrics.ripple_mm:.2f} and "
        f"{runs['normal_edge', SLIDE].metrics.ripple_mm:.2f} mm (standard deviation).",
    ]


def _force(runs: Runs) -> list[str]:
    found = []
    for grams in WEIGHTS_G:
        for law in LAWS:
            run = runs[f"weight_{grams}g_found", law]
            wrong = np.abs(run.force[:, 0] / run.tip_force[-1, 0] - 1.0) > FOUND
            seconds = (int(np.flatnonzero(wrong)[-1]) + 1 - HUNG_AT) * run.scenario.config.loop.period
            found.append(f"{grams} g in {seconds:.2f} s ({law.replace('_', ' ')})")
    return [
        f"While the arm holds its target, a weight is hung on its tip at iteration {HUNG_AT}. The observer estimates "
        "the force on the tip and applies it to the model, so that a_c, b_c and the conversion to displacement "
        "include the "
        "load. "
        f"It is within {100.0 * FOUND:.0f} % of the truth, and stays there, after: " + ", ".join(found) + ".",
    ]


def _contrast(runs: Runs) -> list[str]:
    same, edge, other = (
        {law: runs[name, law].metrics.tpl_mm for law in LAWS}
        for name in ("normal", "normal_edge", "normal_edge_exchanged")
    )
    found = {law: gains(runs["normal", law]) for law in LAWS}
    kp, kd = (found[SLIDE][i] / found[BACK][i] for i in (0, 1))
    ratio = same[SLIDE] / same[BACK]
    return [
        f"With the same information the two laws are {'equally' if abs(ratio - 1.0) < ALIKE else 'not equally'} "
        "smooth: "
        f"TPL {same[BACK]:.1f} mm and {same[SLIDE]:.1f} mm, {ratio:.3f} times. Both are one control law, acceleration "
        "= "
        "kp error + kd error rate (sliding mode adds epsilon sgn S, "
        f"{gains(runs['normal', SLIDE])[3]:g} m/s², as much as "
        f"{1e6 * gains(runs['normal', SLIDE])[3] / found[SLIDE][0]:.1g} "
        "um of error), and nothing but the gains differs: "
        f"kp = {found[BACK][0]:.0f} and {found[SLIDE][0]:.0f} /s², kd = {found[BACK][1]:.1f} and "
        f"{found[SLIDE][1]:.1f} /s: "
        f"sliding mode's are {kp:.2f} and {kd:.2f} times as high.",
        "The difference appears near the stability limit, with measured differences, which are half a cycle "
        "old, "
        f"and a wrong model. There the path under sliding mode is {edge[SLIDE] / edge[BACK]:.2f} times that under "
        "backstepping "
        f"(the paper: {SIMULATION[SLIDE].tpl_mm / SIMULATION[BACK].tpl_mm:.2f} times). The gains make the "
        "difference, not the "
        "kind of law: under the same condition with the gains exchanged, the path is "
        f"{other[BACK]:.0f} mm for backstepping with sliding mode's gains (sliding mode with its own: "
        f"{edge[SLIDE]:.0f} mm), and {other[SLIDE]:.0f} mm for sliding mode with backstepping's (backstepping with its "
        f"own: {edge[BACK]:.0f} mm).",
    ]


def _variants(runs: Runs) -> list[str]:
    normal = runs["normal", BACK]
    as_written = runs["normal_papers_z", BACK].metrics
    converged = runs["normal_rk6", BACK].metrics
    x, _, z = as_written.final_tip_m
    path = normal.metrics.path_overshoot_percent
    return [
        "- Overshoot is mostly geometry: resting rods pass x = "
        f"{1e3 * normal.furthest:.1f} mm before the target, "
        f"{100 * (normal.furthest / normal.target[0] - 1):.1f} % "
        f"beyond it. Along the equilibrium curve backstepping overshoots by {path or 0.0:.1f} %.\n"
        f"- z target 0, as the paper writes it: no resting rod is at (340, 0) mm; the tip rests at ({1e3 * x:.1f}, "
        f"{1e3 * z:.1f}) mm, {as_written.steady_state_error_mm:.1f} mm from x = 340 mm. With the reachable z of "
        f"{1e3 * normal.target[2]:.1f} mm the error is {normal.metrics.steady_state_error_mm:.3f} mm.\n"
        "- The paper's scheme is first order in space. A converged rod rests at z = "
        f"{1e3 * converged.final_tip_m[2]:.1f} mm "
        f"with {1e3 * converged.final_displacement_m:.1f} mm of tendon (paper's scheme: "
        f"{1e3 * normal.metrics.final_displacement_m:.1f} mm; the paper prints "
        f"{SIMULATION[BACK].final_displacement_mm:.0f} mm).",
    ]


def _loads(runs: Runs) -> list[str]:
    x, _, z = DISTURBANCE
    lines = [
        f"Weights pull on the tip along gravity, -x, from the start. The disturbance of {x:g} N in x and {z:g} N in z "
        "acts "
        f"on the tip for {DISTURBANCE_CYCLES} cycle from iteration {DISTURBED_AT} on; the paper gives no duration.",
    ]
    rests = []
    for grams in WEIGHTS_G:
        fixed, free = (runs[f"weight_{grams}g{suffix}", BACK].metrics for suffix in ("", "_yielding"))
        rests.append(
            f"with {grams} g the error of x is {fixed.steady_state_error_mm:.2f} mm, with a target of x alone "
            f"{free.steady_state_error_mm:.2f} mm"
        )
    lines.append(
        "The target stays the point that an unloaded rod reaches. A loaded one has another shape at x = 340 mm, and "
        "b_c, "
        f"of rank 1, cannot compensate it: {'; '.join(rests)}, both laws alike."
    )
    reach = {
        (suffix, law): deviation(runs[f"disturbance{suffix}", law], DISTURBED_AT)
        for suffix in ("", "_edge")
        for law in LAWS
    }
    lines.append(
        f"The disturbance displaces the tip by {reach['', BACK]:.0f} mm (backstepping) and {reach['', SLIDE]:.0f} mm "
        "(sliding "
        f"mode); at the edge of stability {reach['_edge', BACK]:.0f} and {reach['_edge', SLIDE]:.0f} "
        "mm. The "
        "paper finds both laws about equal in this case."
    )
    lost = [run for (name, _), run in runs.items() if name.endswith("g_edge") and run.ending]
    if lost:
        named = "; ".join(f"{run.scenario.title}, {run.law.replace('_', ' ')}: {run.ending}" for run in lost)
        lines.append(
            f"Not every run at the edge ends at its target: {named}. The tip is pushed past the bend at which the sign "
            "of dx and b_c changes, and the law keeps pulling until a fault releases the tendons. The paper shows no "
            "such "
            "run."
        )
    return lines


def _lyapunov(runs: Runs) -> list[str]:
    texts = []
    for scenario in ("normal", "normal_edge"):
        for law in LAWS:
            run = runs[scenario, law]
            found = find_rises(run)
            last = max([*found.limit, *found.rank, *found.sampled], default=None)
            end = float(run.lyapunov[-1])
            texts.append(
                f"- {run.scenario.title}, {law.replace('_', ' ')}: "
                + (
                    "V never rises before it rests"
                    if last is None
                    else f"V rises for the last time after iteration {last}"
                )
                + f"; it ends at {end:.1e} m²/s²."
            )
    return [
        "In theory V decreases in continuous time, along the directions that b_c reaches, without limits on U. "
        "It does not always do so here because of: the first cycles, in which the tension limits restrict the law; "
        "the rank of b_c, whose columns "
        "all "
        "lie across the tip's axis, so that the part of V along the axis follows the rod's shape alone; and the "
        "sampling: "
        "at 100 Hz alpha1 dt and c dt are "
        f"{gains(runs['normal', BACK])[2]:.0f} and {gains(runs['normal', SLIDE])[2]:.0f}, far beyond what a held "
        "command "
        "can follow; V decreases only because the model's velocity and acceleration include the command just applied. "
        "With measured velocity and a wrong model it does not decrease monotonically.",
        "\n".join(texts),
        "With the same information, the final value of V lies along the tip's axis, "
        + " and ".join(
            f"{100.0 * along_share(runs['normal', law]):.1f} % of it ({law.replace('_', ' ')})" for law in LAWS
        )
        + ": the target's z is given to a tenth of a millimetre, and b_c does not reach the rest.",
    ]


_TOPICS = {
    "edge": _edge,
    "force": _force,
    "contrast": _contrast,
    "variants": _variants,
    "loads": _loads,
    "rig": rig_paragraphs,
    "rig loads": rig_load_paragraphs,
    "lyapunov": _lyapunov,
}
