"""Versions of configuration files, and the migration from one to the next."""
