"""Motion capture: frames of any camera system become poses of the tip on the bus."""
