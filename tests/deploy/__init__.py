"""What is installed on a rig, from the source distribution on."""
