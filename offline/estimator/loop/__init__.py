"""The loop with the filter beside that with fixed gains: the same laws on the same plants, unlike the model."""
