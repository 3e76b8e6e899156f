"""Everything that works on logs or runs simulations; nothing in here runs on a rig."""
