"""Friction of tendons on their guides: Coulomb's law along the whole path of an elastic tendon (capstan)."""
