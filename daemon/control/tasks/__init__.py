"""Tasks of a law: to move the tip in the bending plane with a pair of tendons, or in space with all of them."""
