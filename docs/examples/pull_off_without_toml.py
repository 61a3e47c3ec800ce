"""Pull-off of a sphere from a coating, by two methods: problems and methods are plain objects."""

import jkrcli as jkr

film = jkr.Layer(jkr.Elastic(E=1e6, nu=0.45), thickness=2e-6)
coated = jkr.Specimen((film,), jkr.HalfSpace(jkr.Elastic(E=20e6, nu=0.3)))
problem = jkr.Problem(jkr.Sphere(R=10e-6), coated, jkr.Loading("radius", 4e-6, points=60))
for method in (jkr.Layered(), jkr.Hybrid(tolerance=1e-4)):
    curve = jkr.transform(jkr.solve(problem, method), w=0.05)
    point = curve.pull_off["load"]
    print(f"{type(method).__name__:8} pull-off {point.P * 1e6:.4f} uN at a = {point.a * 1e6:.3f} um")
