"""The smoother: the likeliest motion of the robot by a whole log, with the errors of its model and their spread."""
