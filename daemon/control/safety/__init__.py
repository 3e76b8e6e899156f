"""Safety filter: the least change of a command that keeps body, tip and strain within their constraints."""
