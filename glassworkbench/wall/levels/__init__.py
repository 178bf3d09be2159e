"""The inside as a level set, for the method `inner_mesh`."""
