"""What a log says: reading it, the paper's metrics, figures, a summary."""
