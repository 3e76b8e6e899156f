"""Contact anywhere along the body: found, located and sized by its traces in the filter's innovations."""
