"""Data that cross a boundary: messages, key expressions, records, configuration. No I/O."""
