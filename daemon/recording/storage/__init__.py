"""What is kept of the logs in a folder: retention, checksums, tags and notes."""
