"""The rods that controller and simulator run on: one interface, the shooting rod or the general one behind it."""
