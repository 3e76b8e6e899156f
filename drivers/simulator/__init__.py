"""The simulated rig: a rod plant that speaks the same messages as the real one."""
