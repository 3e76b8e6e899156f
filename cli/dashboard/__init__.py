"""`tendond dashboard`: a rig in the browser."""
