"""The predictive law: horizon, model along it, program, closed loop."""
