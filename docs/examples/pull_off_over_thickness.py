"""How the pull-off force grows as a bonded layer gets thinner: one solve per thickness, any number of w."""

import math

import jkrcli as jkr

R = 10e-6  # m
WORKS = (0.005, 0.05)  # J/m^2
print("h [um]   " + "   ".join(f"w = {w * 1e3:2g} mJ/m^2" for w in WORKS))
for h in (100e-6, 10e-6, 3e-6, 1e-6):
    solved = jkr.solve(
        jkr.parse_case(f"""
        indenter = {{ shape = "paraboloid", radius = {R} }}
        specimen.layers = [{{ thickness = {h}, E = "1 MPa", nu = 0.45 }}]
        loading = {{ radius = "6 um" }}
        """)
    )
    forces = [jkr.transform(solved, w=w).pull_off["load"].P / (math.pi * w * R) for w in WORKS]
    print(f"{h * 1e6:6g}   " + "   ".join(f"{force:13.4f}" for force in forces) + "   (in pi w R)")
