"""Study of the safety filter: robots unlike the model are sent beyond obstacles."""
