"""A tendon-driven robot in MuJoCo: a plant that shares no mechanics with the rod model, which it does not import."""
