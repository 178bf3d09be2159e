"""OCC's offset made to hold, for the method `thick_solid`."""
