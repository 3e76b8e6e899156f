"""Commands that identify a rig."""
