"""Data sets of measured tips: adapters that read others' files and a lab's own."""
