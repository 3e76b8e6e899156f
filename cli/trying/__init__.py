"""`tendond try`: a rig's configuration on the simulator, in one command."""
