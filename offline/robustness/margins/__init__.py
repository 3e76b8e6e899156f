"""Margins of the sampled loop: gains, loops on plants unlike the model, stiffness of the bent rod."""
