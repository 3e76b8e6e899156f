"""The estimator on robots unlike its model: how near it comes, and whether it knows how near."""
