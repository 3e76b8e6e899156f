"""Load every kernel from the cache, or compile it: `python -m tendond.model.warm` is the last step of a set-up."""

import numpy as np

from tendond.model.announce import announce_compilation
from tendond.model.parameters import RodParameters
from tendond.model.rod import Rod


def warm_up() -> None:
    """Run each kernel once, for a rod of four tendons; takes a second when they are cached."""
    rod = Rod(RodParameters(), "euler", nodes=10)
    state = rod.step(rod.solve_static())
    rod.tip(state)
    rod.sensitivity(state)
    rod.forecast(state, np.zeros(4), np.ones((2, 4)), np.zeros(3))
    rod.tip_response(state, 0)


if __name__ == "__main__":
    announce_compilation(lambda line: print(f"tendond: {line}", flush=True))
    warm_up()
