"""Model predictive control: the horizon, the model along it, the limits, the quadratic program."""
