"""Tests of the servo tools: scan, setup, calibrate, home, pretension."""
