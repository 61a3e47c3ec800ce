"""Transversely isotropic layers and half-spaces in Hankel space: the minors' equation with other constants.

In units of C44 the state equations have the constants c = C13/C33, beta = C44/C33, e = (C11 - C13^2/C33)/C44, and B
the eigenvalues 0, +-(s1 + s2), +-(s1 - s2), where exp(-s_j k z) are the half-space's two fields, real or conjugate.
With X = A^2 or D^2, A = s1 + s2, D = s1 - s2, and sinh and cosh as functions of X,

    exp(B y) = I + B (o(D^2) + o1 (B^2 - D^2)) + B^2 (q(D^2) + q1 (B^2 - D^2)),
    o(X) = sinh(sqrt(X) y)/sqrt(X),   q(X) = (cosh(sqrt(X) y) - 1)/X,   o1, q1: differences over A^2 - D^2,

which for A = 2, D = 0 is the isotropic one of ``minors``; here it carries the factor exp(-A y).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...bodies.materials import TransverselyIsotropic

Array = np.ndarray

SMALL = 2.0  # below this A y and |D| y the differences are summed as power series
TERMS = 14


@dataclass(frozen=True)
class Medium:
    """The constants of the minors' equation for one material."""

    c: float
    beta: float
    e: float

    @classmethod
    def of(cls, material: TransverselyIsotropic) -> Medium:
        C11, _, C13, C33, C44 = material.stiffness
        return cls(C13 / C33, C44 / C33, (C11 - C13**2 / C33) / C44)

    @cached_property
    def _root(self) -> float:
        """s1 s2."""
        return math.sqrt(self.c**2 + self.e * self.beta)

    @property
    def squares(self) -> tuple[float, float]:
        """A^2 and D^2."""
        middle = self.e - 2 * self.c
        return middle + 2 * self._root, middle - 2 * self._root

    @property
    def slowest(self) -> float:
        """The lesser real part of s1 and s2: fields die out as exp(-slowest k z)."""
        A2, D2 = self.squares
        return (math.sqrt(A2) - math.sqrt(max(D2, 0.0))) / 2

    @property
    def half_space(self) -> list[float]:
        """Minors of the half-space: where the Riccati equation of F stands still."""
        rz = (self.c - self._root) / self.e
        rr = math.sqrt((1 - 2 * rz) / self.e)
        zz = rr * self._root
        return [1.0, rr, zz, rz, rr * zz - rz**2]

    def generator(self, m: Array) -> Array:
        """B m."""
        out = np.empty_like(m)
        out[0] = self.e * m[1]
        out[1] = m[0] - 2 * m[3]
        out[2] = self.beta * m[0] + 2 * self.c * m[3] + self.e * m[4]
        out[3] = self.c * m[1] - m[2]
        out[4] = self.beta * m[1] + m[2]
        return out

    def through(self, m: Array, y: Array) -> Array:
        """exp(B y) m exp(-A y): the minors (5, n) one layer of y = k h further up."""
        _, D2 = self.squares
        o, q, o1, q1 = self._functions(y)
        b1 = self.generator(m)
        b2 = self.generator(b1)
        b3 = self.generator(b2)
        b4 = self.generator(b3)
        once = np.exp(-math.sqrt(self.squares[0]) * y)
        return once * m + (o - D2 * o1) * b1 + (q - D2 * q1) * b2 + o1 * b3 + q1 * b4

    def _functions(self, y: Array) -> tuple[Array, Array, Array, Array]:
        """o and q of D^2, o1, q1, all times exp(-A y)."""
        A2, D2 = self.squares
        A = math.sqrt(A2)
        o_A, q_A = _hyperbolic(A2, y, A)
        o, q = _hyperbolic(D2, y, A)
        largest = math.sqrt(max(A2, -D2))  # |D| > A under a stiffness in shear far above the others
        x = np.minimum(y, SMALL / largest)
        odd, even, power = np.zeros_like(y), np.zeros_like(y), 1.0
        difference = 0.0
        for n in range(1, TERMS + 1):
            difference, power = A2 * difference + power, power * D2
            odd += difference * x ** (2 * n + 1) / math.factorial(2 * n + 1)
            even += difference * x ** (2 * n + 2) / math.factorial(2 * n + 2)
        small, decay = largest * y < SMALL, np.exp(-A * x)
        o1 = np.where(small, odd * decay, (o_A - o) / (A2 - D2))
        q1 = np.where(small, even * decay, (q_A - q) / (A2 - D2))
        return o, q, o1, q1


def _hyperbolic(X: float, y: Array, A: float) -> tuple[Array, Array]:
    """o(X) and q(X), times exp(-A y), A >= sqrt(X)."""
    d = math.sqrt(abs(X))
    x = np.maximum(d * y, 1e-300)
    if X < 0:
        decay = np.exp(-A * y)
        return y * decay * np.sin(x) / x, y**2 / 2 * decay * (np.sin(x / 2) / (x / 2)) ** 2
    decay = np.exp((d - A) * y)
    return y * decay * -np.expm1(-2 * x) / (2 * x), y**2 / 2 * decay * (np.expm1(-x) / x) ** 2
