"""Movies of a run: its pictures, and the files that hold them."""
