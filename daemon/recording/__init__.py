"""The MCAP log: recorder, channels, retention."""
