"""The closed loop over a grid of plants that differ from the controller's model: `tendond study robustness`."""
