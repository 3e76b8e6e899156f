"""A robot cut into modes, mass points and quadrature points."""
