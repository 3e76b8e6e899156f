"""The paper reproduced: its numbers, its simulations run offline, tables, figures, and a page that compares both."""
