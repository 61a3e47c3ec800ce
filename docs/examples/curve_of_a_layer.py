"""The adhesive curve of a soft layer, its pull-off point, and how far the half-space's formula is off."""

import math

import jkrcli as jkr

R, w = 10e-6, 0.05  # m, J/m^2
case = jkr.parse_case(f"""
[indenter]
shape = "sphere"
radius = {R}

[[specimen.layers]]
thickness = "5 um"
E = "1 MPa"
nu = 0.499

[loading]
radius = "8 um"
""")
curve = jkr.transform(jkr.solve(case), w=w)
point = curve.pull_off["load"]
print(f"pull-off {point.P * 1e6:.3f} uN at a = {point.a * 1e6:.2f} um, estimated error {curve.budget.total:.0e}")
print(f"in units of pi w R: {point.P / (math.pi * w * R):.4f} (half-space: -1.5)")
jkr.plot(curve, "layer.svg")
