"""Train a policy by imitation of the law 'sensitivity', and compare both on robots unlike the model.

A policy that has only seen the law's own runs leaves them and does not come back. So it drives some runs itself, and
learns what the law would have asked for there (S. Ross, G. Gordon, D. Bagnell, "A reduction of imitation learning and
structured prediction to no-regret online learning", AISTATS 2011: DAgger).

python examples/learn_policy.py learn_policy.png

With a second file, policy.npz, the policy is kept there, for [control.laws.policy] of a configuration.
"""

import sys
import tempfile
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from tendond.daemon.control.laws import LAWS, SPACE, Decision, SpatialObservation, StatelessLaw, policy, sensitivity
from tendond.daemon.control.laws.policy import Parameters, observed
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.learning.policy_file import read_policy, save_policy
from tendond.offline.robustness.unlike import unlike
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

LENGTH, TENSION, RATE, HIDDEN = 0.5, 60.0, 200.0, 32  # m, N, N/s
PERIOD, ARM = 0.01, 20
random = np.random.default_rng(0)


def rig(target: float, law: str, table: dict | None = None, stiffness: float = 1.0, **simulator: object) -> RigConfig:
    """Return a rig that moves its tip to x = target [m] with a law."""
    config = check_config(
        {
            "control": {"law": law, "laws": {} if table is None else {"policy": table}},
            "reference": {"across": target},
            "simulator": simulator,
        },
        "learn_policy",
    )
    plant = config.simulator.model_copy(update={"rod": unlike(config.simulator.rod, stiffness)})
    return config.model_copy(update={"simulator": plant})


def records(config: RigConfig, cycles: int = 250) -> list:
    """Return the cycles that track."""
    run = watched_loop(config, cycles, {ARM: ControlAction.ARM})
    return [one.record for one in run if one.record.mode is Mode.TRACKING]


class Teacher:
    """The law 'sensitivity', which notes what it sees and asks for while a policy, if there is one, drives."""

    def __init__(self) -> None:
        self.policy: Parameters | None = None
        self.seen: list[np.ndarray] = []
        self.asked: list[np.ndarray] = []

    def decide(self, parameters: sensitivity.Parameters, now: SpatialObservation) -> Decision:
        """Return the tensions wanted by whoever drives."""
        wanted = sensitivity.decide(parameters, now)
        self.seen.append(observed(now.position, now.velocity, now.target, now.target_velocity, now.tension))
        self.asked.append(np.clip((wanted.tension - now.tension) / (RATE * PERIOD), -1.0, 1.0))
        return wanted if self.policy is None else policy.decide(self.policy, now)

    def runs(self, count: int) -> None:
        """Run robots, targets and pushes that are drawn."""
        for run in range(count):
            pushes = [
                {"time": float(at), "duration": 0.05, "force": random.normal(0.0, 1.0, 3).tolist()} for at in (0.8, 1.4)
            ]
            target, stiffness = random.uniform(0.15, 0.34), random.uniform(0.85, 1.15)
            records(rig(target, "teacher", None, stiffness, impacts=pushes, mocap={"noise": 1e-4}, seed=run))


def trained(seen: np.ndarray, asked: np.ndarray, epochs: int = 60) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the layers that map one to the other, by Adam on the square error."""
    x = seen / np.concatenate((np.full(12, LENGTH), np.full(seen.shape[1] - 12, TENSION)))
    spread = np.maximum(x.std(axis=0), 1e-3)  # the first layer's inputs are of like size, though scaled by the robot
    sizes = (x.shape[1], HIDDEN, asked.shape[1])
    layers = [[random.normal(0.0, n**-0.5, (m, n)), np.zeros(m)] for n, m in pairwise(sizes)]
    layers[0][0] /= spread
    layers[0][1] -= layers[0][0] @ x.mean(axis=0)
    steps = [[1.0 / spread**2 if index == 0 else 1.0, 1.0] for index in range(2)]
    moments = [[np.zeros_like(one) for one in layer] for layer in layers]
    squares = [[np.zeros_like(one) for one in layer] for layer in layers]
    count = 0
    for epoch in range(epochs):
        rate = 3e-3 * 0.5 * (1.0 + np.cos(np.pi * epoch / epochs))
        order = random.permutation(len(x))
        for part in np.array_split(order, max(1, len(x) // 128)):
            (W0, b0), (W1, b1) = layers
            hidden = np.tanh(x[part] @ W0.T + b0)
            out = np.tanh(hidden @ W1.T + b1)
            back = 2.0 * (out - asked[part]) * (1.0 - out**2) / len(part)
            inner = (back @ W1) * (1.0 - hidden**2)
            gradients = [[inner.T @ x[part], inner.sum(0)], [back.T @ hidden, back.sum(0)]]
            count += 1
            for layer, m, v, g, scale in zip(layers, moments, squares, gradients, steps, strict=True):
                for k in range(2):
                    g[k] = g[k] * (scale[k] ** 0.5 if k == 0 else 1.0)  # Adam in the scaled coordinates
                    m[k] = 0.9 * m[k] + 0.1 * g[k]
                    v[k] = 0.999 * v[k] + 0.001 * g[k] ** 2
                    move = (m[k] / (1 - 0.9**count)) / (np.sqrt(v[k] / (1 - 0.999**count)) + 1e-8)
                    layer[k] = layer[k] - rate * move * (scale[k] ** 0.5 if k == 0 else 1.0)
    return [(W, b) for W, b in layers]


def main(picture: Path, file: Path, runs: int = 6, rounds: int = 5) -> dict[str, float]:
    """Train, compare, draw; return the steady errors on unlike robots by law [mm]."""
    teacher = Teacher()
    LAWS.register(StatelessLaw("teacher", sensitivity.Parameters, teacher.decide, SPACE, rates=sensitivity.rates))
    for _ in range(rounds):
        teacher.runs(runs)
        layers = trained(np.array(teacher.seen), np.array(teacher.asked))
        save_policy(file, layers, length=LENGTH, tension=TENSION, rate=RATE)
        teacher.policy = Parameters.model_validate(read_policy(file))
    plt.figure(figsize=(7, 3.2), layout="constrained")
    worst = {}
    for law, line in (("sensitivity", "--"), ("policy", "-")):
        errors = []
        for target, stiffness in ((0.2, 0.85), (0.3, 1.15)):
            found = records(rig(target, law, read_policy(file) if law == "policy" else None, stiffness, seed=99))
            error = 1e3 * np.array([np.linalg.norm(np.subtract(one.measured, one.reference.position)) for one in found])
            errors.append(error[-20:].mean())
            label = f"{law}, x = {target} m, E x {stiffness}"
            plt.semilogy(PERIOD * np.arange(len(error)), error, line, label=label)
        worst[law] = float(max(errors))
    plt.gca().set(xlabel="time [s]", ylabel="error of the tip [mm]", title="A policy that has seen the law only")
    plt.legend(fontsize="small")
    plt.savefig(picture, dpi=110)
    return worst


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        errors_by_law = main(Path(sys.argv[1]), Path(sys.argv[2] if len(sys.argv) > 2 else f"{folder}/policy.npz"))
    print({law: round(error, 2) for law, error in errors_by_law.items()})
