"""A log run again: the same cycles to the same bytes, or what another law or parameter would have done."""
