"""`tendond teleop`: move the target by hand, with keys or a gamepad."""
