"""The logs of a folder."""
