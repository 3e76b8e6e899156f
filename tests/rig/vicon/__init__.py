"""Tests of `tendond rig vicon` on real sockets."""
