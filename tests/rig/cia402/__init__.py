"""Drives on a CAN bus."""
