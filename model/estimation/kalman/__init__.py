"""The estimator: an extended Kalman filter on the general rod's linearisation, with a memory for late measurements."""
