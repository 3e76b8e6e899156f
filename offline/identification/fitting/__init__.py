"""The least-squares fit and its statistics."""
