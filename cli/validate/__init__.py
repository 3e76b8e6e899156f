"""`tendond validate`: the general rod beside measured robots."""
