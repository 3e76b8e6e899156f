"""Tests of `tendond mocap` on real wires."""
