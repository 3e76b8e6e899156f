"""Commands of a rig: processes, operator's requests, live view, diagnosis."""
