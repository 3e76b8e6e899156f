"""The displacement-driven rod through a recording, with any parameters."""
