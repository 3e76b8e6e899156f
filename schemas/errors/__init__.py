"""Messages about a configuration that cannot be used: key, line, value, what is allowed."""
