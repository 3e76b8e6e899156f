"""A client's end of the bus: session, subscriptions, requests, identity, readiness; used by drivers and commands."""
