"""The half-space that raw records are fitted as, as a case file: its E is not that of the records."""

from __future__ import annotations

CASE = """
[indenter]
shape = "{shape}"
radius = "5 um"
[specimen.half_space]
E = "100 kPa"
nu = 0.5
[loading]
radius = "1 um"
points = 60
spacing = "log"
"""
