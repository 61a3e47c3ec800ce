"""Knows no mechanics: errors, units, files, clocks, work on many items."""
