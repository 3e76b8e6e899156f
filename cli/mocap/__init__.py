"""`tendond mocap`: the cameras, and their calibration."""
