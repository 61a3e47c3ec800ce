"""The Fredholm equation of axisymmetric contact, for any smooth kernel: kernel, quadrature, equation, densities, radii.

    phi(x) + (2/pi) int_0^a K(x,t) phi(t) dt = (2/pi) (delta - F(x)),    0 <= x <= a        (Lebedev-Ufliand)

A method of this kind knows the kernel K of its bodies (``layered`` from the compliance spectrum of a stack, ``hybrid``
from finite elements) and leaves the rest to this folder.
"""
