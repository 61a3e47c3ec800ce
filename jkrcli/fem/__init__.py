"""Axisymmetric finite elements: mesh, elasticity, contact on the condensed surface, fields in the body."""
