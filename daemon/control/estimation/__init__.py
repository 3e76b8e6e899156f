"""The estimator of a configuration, beside the phases that use it."""
