"""What crosses a boundary: messages, key expressions, configuration. No I/O."""
