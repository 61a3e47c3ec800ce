"""Bodies that relax and adhesion over the speed of the edge: contact over time, and its fits."""
