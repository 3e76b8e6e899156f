"""Tendons: allocation of tensions."""
