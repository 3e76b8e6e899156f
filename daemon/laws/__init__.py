"""The control laws, one pure function per module."""
