"""Time steps of the general rod: the balance of one, its derivative, and the method that solves it."""
