"""The command line of tendond."""
