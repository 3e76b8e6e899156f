"""Second derivatives of a shape by its strains, for exact matrices and linear models."""
