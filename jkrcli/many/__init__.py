"""Many problems: sweeps and studies."""
