"""Adhesive (JKR) contact of axisymmetric bodies: nonadhesive series in, adhesive curves out.

Lengths in m, forces in N, moduli in Pa, work of adhesion in J/m^2; compression and indentation are positive.
"""

__version__ = "0.1.0"
