"""E* and w from a measured curve on a layer: here a computed curve with noise and a shifted origin."""

from pathlib import Path

import numpy as np

import jkrcli as jkr

case = jkr.parse_case("""
[indenter]
shape = "paraboloid"
radius = "10 um"

[[specimen.layers]]
name = "gel"
thickness = "8 um"
E = "1 MPa"
nu = 0.499

[loading]
radius = "6 um"
""")
true = jkr.transform(jkr.solve(case), w=0.05, modulus_factor=0.7)
rows = slice(20, None)  # from near pull-off on
delta, P = (jkr.table(true)[name][rows] for name in ("delta_m", "P_N"))
noise = np.random.default_rng(1)
delta_scale, P_scale = abs(true.pull_off["displacement"].delta), abs(true.pull_off["load"].P)
delta = delta + 30e-9 + 0.01 * delta_scale * noise.standard_normal(delta.size)
P = P + 0.01 * P_scale * noise.standard_normal(P.size)
lines = [f"{d * 1e9},{p * 1e9}" for d, p in zip(delta, P, strict=True)]
Path("measured.csv").write_text("\n".join(["delta_nm,P_nN", *lines]) + "\n")

found = jkr.fit(case, "measured.csv")
for name, unit, factor in (("w", "mJ/m^2", 1e3), ("modulus", "times the case's E", 1), ("delta0", "nm", 1e9)):
    item = found.estimate(name)
    print(f"{name:8} {item.value * factor:8.4g} {unit}, 95 % [{item.low * factor:.4g}, {item.high * factor:.4g}]")
