"""Studies that users run: maps of pull-off, convergence of the mesh."""
