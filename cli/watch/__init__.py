"""The live view in the terminal: the snapshot of the bus, and its drawing; no bus and no clock."""
