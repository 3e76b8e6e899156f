"""The discrete loop near its equilibria: eigenvalues of the real cycle with its plant, and a map of them."""
