"""Commands about a configuration."""
