"""The controller: laws, reference, cycle, loop, bus, recorder and analysis."""
