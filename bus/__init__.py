"""The client's end of the bus, shared by drivers and commands: session, operator's requests, identity, readiness."""
