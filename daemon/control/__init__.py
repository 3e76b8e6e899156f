"""The cycle as pure functions: inputs, modes, estimate, reference, law, limits, record. No clock, no I/O."""
