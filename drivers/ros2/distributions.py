"""Distributions of ROS 2 whose nodes the bridge speaks to; without any library, for the command line."""

from typing import Literal

Distribution = Literal["jazzy", "kilted", "rolling", "humble"]

DISTRIBUTIONS: tuple[Distribution, ...] = ("jazzy", "kilted", "rolling", "humble")
DEFAULT_DISTRIBUTION: Distribution = "jazzy"

ROUTER = "tcp/localhost:7447"
"""Endpoint on which rmw_zenohd listens by default."""

DOMAIN_MAX = 232
"""Largest ROS_DOMAIN_ID that every middleware can use (ROS 2's documentation, "The ROS_DOMAIN_ID")."""
