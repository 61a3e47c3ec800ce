"""Laws of Young's modulus over depth, measured from the top of the layer that has them."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np

from ..base import AnyLength, Array, InputError, Key, Length, Modulus, Ranged, Registry, positive

LAWS = Registry(inherited="thickness")
law = LAWS.register  # decorator: the name by which ``E = { law = ... }`` of a case file calls it


class Law(ABC):
    """E(z) > 0 [Pa] for 0 <= z <= ``reach`` [m], smooth between its ``kinks``; a frozen dataclass."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """The depth [m] down to which the law is defined."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Depths [m] inside the reach at which the slope jumps."""
        return ()

    @abstractmethod
    def at(self, depth: Array) -> Array:
        """E [Pa] at ``depth`` [m], same shape."""

    @abstractmethod
    def taylor(self, count: int) -> Array:
        """The first ``count`` coefficients of E(z)/E(0) in powers of z at the top [m^-n]."""

    @abstractmethod
    def scaled(self, factor: float) -> Self:
        """The same law with all moduli multiplied by ``factor``."""


@dataclass(frozen=True)
class _Between(Law):
    """A smooth law from ``top`` to ``bottom`` [Pa] over ``depth`` [m]."""

    top: Modulus
    bottom: Modulus
    depth: Annotated[float, Key("thickness")]

    def __post_init__(self) -> None:
        positive("Pa", top=self.top, bottom=self.bottom)
        positive("m", depth=self.depth)

    @property
    def reach(self) -> float:
        return self.depth

    def scaled(self, factor: float) -> Self:
        return replace(self, top=self.top * factor, bottom=self.bottom * factor)


@law("linear")
class Linear(_Between):
    """E = top + (bottom - top) z/depth."""

    def at(self, depth: Array) -> Array:
        return self.top + (self.bottom - self.top) * np.asarray(depth, dtype=float) / self.depth

    def taylor(self, count: int) -> Array:
        return np.append([1.0, (self.bottom / self.top - 1) / self.depth], np.zeros(count))[:count]


@law("exponential")
class Exponential(_Between):
    """E = top (bottom/top)^(z/depth)."""

    @property
    def rate(self) -> float:
        """d(ln E)/dz [1/m]."""
        return math.log(self.bottom / self.top) / self.depth

    def at(self, depth: Array) -> Array:
        return self.top * np.exp(self.rate * np.asarray(depth, dtype=float))

    def taylor(self, count: int) -> Array:
        return np.array([self.rate**n / math.factorial(n) for n in range(count)])


@law("power")
@dataclass(frozen=True)
class Power(Law):
    """E = top (1 + z/length)^exponent; any real ``exponent``."""

    top: Modulus
    length: Length
    exponent: Annotated[float, Ranged("number")]

    def __post_init__(self) -> None:
        positive("Pa", top=self.top)
        positive("m", length=self.length)
        if not math.isfinite(self.exponent):
            raise InputError(f"exponent: must be a finite number, got {self.exponent:g}")

    @property
    def reach(self) -> float:
        return math.inf

    def at(self, depth: Array) -> Array:
        return self.top * (1 + np.asarray(depth, dtype=float) / self.length) ** self.exponent

    def taylor(self, count: int) -> Array:
        ratios = [(self.exponent - n + 1) / (n * self.length) for n in range(1, count)]
        return np.array(list(itertools.accumulate(ratios, lambda c, ratio: c * ratio, initial=1.0)))

    def scaled(self, factor: float) -> Self:
        return replace(self, top=self.top * factor)


@law("table")
@dataclass(frozen=True)
class Tabulated(Law):
    """``moduli`` [Pa] at increasing ``depths`` [m] from 0 on, straight lines between them."""

    depths: Annotated[tuple[AnyLength, ...], Key("depth")]
    moduli: Annotated[tuple[Modulus, ...], Key("E")]

    def __post_init__(self) -> None:
        if len(self.depths) != len(self.moduli) or len(self.depths) < 2:
            raise InputError(
                "a table needs as many moduli as depths, at least two of each, "
                f"got {len(self.moduli)} and {len(self.depths)}"
            )
        if self.depths[0] != 0 or any(not b > a for a, b in itertools.pairwise(self.depths)):
            raise InputError(f"depth: must start at 0 m and increase, got {list(self.depths)}")
        if not math.isfinite(self.depths[-1]):
            raise InputError(f"depth: must be finite, got {self.depths[-1]:g} m")
        wrong = [modulus for modulus in self.moduli if not (math.isfinite(modulus) and modulus > 0)]
        if wrong:
            raise InputError(f"E: every modulus must be > 0 Pa, got {wrong[0]:g}")

    @property
    def reach(self) -> float:
        return self.depths[-1]

    @property
    def kinks(self) -> tuple[float, ...]:
        return self.depths[1:-1]

    def at(self, depth: Array) -> Array:
        return np.interp(np.asarray(depth, dtype=float), self.depths, self.moduli)

    def taylor(self, count: int) -> Array:
        return np.append([1.0, (self.moduli[1] / self.moduli[0] - 1) / self.depths[1]], np.zeros(count))[:count]

    def scaled(self, factor: float) -> Self:
        return replace(self, moduli=tuple(modulus * factor for modulus in self.moduli))
