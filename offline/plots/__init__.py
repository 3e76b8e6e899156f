"""Figures and reports of runs. Import the modules only to draw: matplotlib takes a second."""
