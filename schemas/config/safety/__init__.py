"""[safety]: where the body may be, and how far it may be bent."""
