"""Tests of tendond."""
