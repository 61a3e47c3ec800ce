"""What an indenter must know, and the shapes by which case files call them.

An indenter is a rigid or elastic, convex, axisymmetric profile f(r). What the contact problem needs of it is the Abel
image F; on a half-space F is the displacement itself: delta_H(a) = F(a) (Sneddon 1965).
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from ..base.numerics import Array
from ..base.registry import Registry
from .materials import Solid

SHAPES = Registry(inherited="material", word="shape")
shape = SHAPES.register  # decorator: the shape by which the table [indenter] of a case file calls it


class Indenter(ABC):
    """Describe a convex axisymmetric profile f(r); base of the frozen dataclasses of ``bodies/indenters``.

    A shape has a field ``material``, None where rigid, and a ``noun`` for messages; the table [indenter] of a case file
    calls it by the name of its decorator ``@shape("name")``, its other fields are the keys.

    Methods
    -------
    f(r)
        Profile [m] at radii r (n,) [m]: f(0) = 0, infinite beyond ``r_max``.
    slope(r)
        Slope f'(r) (n,) [-].
    abel(x)
        Abel image F(x) = x int_0^x f'(r)/sqrt(x^2 - r^2) dr (n,) [m].
    abel_slope(x)
        F'(x) (n,) [-], x > 0.
    words
        Property: the shape for a sentence, "sphere R = 100 um".

    Notes
    -----
    On a half-space delta_H(a) = F(a) and P_H = 2 E* int_0^a (F(a) - F(x)) dx (Sneddon, Int. J. Eng. Sci. 3 (1965) 47);
    ``half_space`` gives both where they have a closed form. ``a0``, ``tip_radius``, ``kinks`` and ``joints`` have
    defaults of a smooth tip without a radius.
    """

    material: Solid | None
    noun: ClassVar[str]  # what messages call it: "tabulated profile"

    @property
    def a0(self) -> float:
        """Contact radius at first touch [m]: 0 for round and pointed indenters, > 0 for a flat end."""
        return 0.0

    @property
    def r_max(self) -> float:
        """Largest radius at which the profile is defined [m]."""
        return math.inf

    @property
    def tip_radius(self) -> float | None:
        """Radius of curvature at the tip [m]; None where there is none (cone, flat end, blunt power laws)."""
        return None

    @property
    def kinks(self) -> tuple[float, ...]:
        """Radii > 0 [m] where the slope f' bends, and with it F, increasing."""
        return ()

    @property
    def bends(self) -> tuple[float, ...]:
        """The kinks [m] that are meant, and not what is left between the points of a table."""
        return self.kinks

    @property
    def joints(self) -> tuple[float, ...]:
        """Radii > 0 [m] at which formulas of f begin, the kinks among them, increasing: where quadrature is cut."""
        return self.kinks

    @property
    def contact_share(self) -> float:
        """Contact area of the tip over that of the body of revolution that stands for it, at equal depth."""
        return 1.0

    @property
    def remark(self) -> str:
        """What stands for the tip, where that is a convention that results depend on; else empty."""
        return ""

    def resolution(self, a: Array) -> Array:
        """Errors (2, n) of F [m] and of its slope up to the radii ``a`` (n,), where f is only known at points."""
        return np.zeros((2, a.size))

    @property
    def thinned(self) -> tuple[Indenter, ...]:
        """The profiles through fewer points, where f is only known at points."""
        return ()

    def left(self, a: Array) -> Array:
        """Errors of F near the radii ``a`` (n,), of its slope, and of the mean of F up to there, over what the
        ``thinned`` profiles change of them, (3, n)."""
        return np.zeros((3, a.size))

    @property
    def keys(self) -> dict[str, Any]:
        """Its keys in the table [indenter] of a case file."""
        return SHAPES.keys_in_file(self)

    @property
    @abstractmethod
    def words(self) -> str:
        """The shape for a sentence: ``sphere R = 100 um``."""

    @abstractmethod
    def f(self, r: Array) -> Array:
        """Profile f(r) [m], f(0) = 0; infinite beyond ``r_max``."""

    @abstractmethod
    def slope(self, r: Array) -> Array:
        """Slope f'(r) [-]."""

    @abstractmethod
    def abel(self, x: Array) -> Array:
        """Abel image F(x) = x int_0^x f'(r)/sqrt(x^2 - r^2) dr [m]."""

    @abstractmethod
    def abel_slope(self, x: Array) -> Array:
        """F'(x) [-], x > 0: F' = F/x + int_0^x r f''(r)/sqrt(x^2 - r^2) dr."""

    def half_space(self, a: Array, E_star: float) -> tuple[Array, Array] | None:
        """delta_H = F(a) [m], P_H = 2 E* int_0^a (F(a) - F(x)) dx [N] on a half-space; None: it has no closed form."""
        return None
