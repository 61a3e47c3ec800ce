"""Studies of the methods themselves: how accuracy depends on mesh, noise and parameters."""
