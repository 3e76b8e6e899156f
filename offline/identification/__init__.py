"""`tendond identify`: the model's parameters, from logs of the rig itself."""
