"""Axisymmetric finite elements: mesh, elasticity, surface compliance, contact; ``fem.method.FEM`` is the method."""
