"""The controller: laws, reference, cycle, loop, bus, recorder, replay and analysis."""
