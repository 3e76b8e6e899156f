"""Processes at the edge: each speaks only schemas over Zenoh."""
