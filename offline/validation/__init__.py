"""Validation of the general rod by measured robots: fit on one part of a data set, errors on the other."""
