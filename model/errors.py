"""Errors of the rod model."""

from tendond import TendondError


class ModelError(TendondError):
    """Base of the model's errors."""


class ParameterError(ModelError):
    """A parameter, scheme or load that the rod cannot take; the message names it, its value and what is allowed."""


class ConvergenceError(ModelError):
    """The boundary value problem was not solved; the state that the step started from is intact.

    Attributes:
        time: time of the step that failed [s], from the state's start; 0 in statics.
        residual: norm of force and moment missing at the tip in the last attempt [N], the moment at the arm
            `solver.shooting.ARM`; NaN when it overflowed.
        iterations: marches along the rod that were spent.
    """

    def __init__(self, what: str, time: float, residual: float, iterations: int) -> None:
        self.time = time
        self.residual = residual
        self.iterations = iterations
        super().__init__(
            f"{what} at t = {time:.4g} s: residual {residual:.3g} N after {iterations} marches along the rod"
        )
