"""The installation on a rig, from the source distribution on."""
