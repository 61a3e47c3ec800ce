"""Bodies bounded by side walls: the contact equation with a kernel that finite elements compute."""
