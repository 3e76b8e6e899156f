"""The study of wrongly wired rigs: every mistake that a first hour is made of, and what comes of it."""
