"""`tendond try`: a rig's configuration on the simulator, with a first target chosen from the robot."""
