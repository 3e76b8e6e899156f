"""The configuration of a rig, a file a section."""
