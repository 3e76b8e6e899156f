"""Commands on logs."""
