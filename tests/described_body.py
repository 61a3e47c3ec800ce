"""Half-spaces that records are fitted as, as case files."""

# Its E is not that of raw records.
CASE = """
indenter = {{ shape = "{shape}", radius = "5 um" }}
specimen.half_space = {{ E = "100 kPa", nu = 0.5 }}
loading = {{ radius = "1 um", points = 60, spacing = "log" }}
"""

# E* = R = 1
UNIT = """
indenter = {{ shape = "paraboloid", radius = 1.0 }}
specimen.half_space = {{ E = 1.0, nu = 0.0 }}
loading = {{ depth = {depth}, points = 40, spacing = "log" }}
"""
