"""What others build and cite tendond by."""
