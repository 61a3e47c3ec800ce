"""A pair of bodies whose kernel is known: contact radii for any loading, and the series that a method returns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any, Protocol

import numpy as np

from ...base import Array, Refusal
from ...bodies import Indenter, Loading, Quantity
from ...series import Series
from ..radii import ROUGH, Response, Search
from .equation import ContactResult

COLUMNS = ("delta", "P", "S", "dS")
LOOSEST = 1e-2  # tolerance of a method; choice: no worse result is worth a method without a mesh

FLOPS_PER_SECOND = 1e10  # of the dense algebra; tuned on series of 100 to 2000 points, by `make bench`


class Contact(Protocol):
    """An indenter on a body whose kernel is known.

    ``scale``: the length over which the kernel varies [m]; ``limit``: the radius up to which it is known [m]. Beyond it
    a search may try its steps, but its result means "more than that".
    """

    @property
    def indenter(self) -> Indenter: ...

    @property
    def E_star(self) -> float: ...

    @property
    def scale(self) -> float: ...

    @property
    def limit(self) -> float: ...

    def plan(self, radii: Array, tolerance: float) -> Any:
        """A discretisation expected to be accurate to ``tolerance`` at the increasing ``radii`` [m]."""
        ...

    def solved(self, radii: Array, plan: Any) -> Any:
        """Nonadhesive contact at the increasing ``radii`` [m]."""
        ...


class InaccurateError(Refusal):
    """Refusal: the tolerance was not reached; ``fixed``: the message where the tolerance is not the user's to choose;
    ``reached``: the relative error in its place, infinite where that is not known."""

    def __init__(self, lines: str | Sequence[str], fixed: str, reached: float = math.inf):
        super().__init__(lines)
        self.fixed, self.reached = fixed, reached

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.lines, self.fixed, self.reached)

    @property
    def would_do(self) -> float:
        """The tolerance that is advised in place of the one that was not reached."""
        return 2 * self.reached


def search(contact: Contact, loading: Loading, accuracy: float) -> Search:
    """The search for the radii of a ``loading``; depths and loads are met to the relative ``accuracy``."""
    accuracies = max(ROUGH, accuracy), accuracy
    return Search(loading, contact.indenter, contact.E_star, partial(response, contact), accuracies, contact.scale)


def response(contact: Contact, to: Quantity, accuracy: float) -> Response:
    """Function delta_H or P_H of the contact radius, with a quadrature planned for ``accuracy``."""
    name, a0 = {"depth": "delta", "load": "P"}[to], contact.indenter.a0
    most = math.sqrt((contact.limit - a0) * (contact.limit + a0))

    def at(radii: Array) -> Array:
        v = np.sqrt((radii - a0) * (radii + a0))
        beyond = max(float(v[-1]) / most, 1.0)
        inside = radii if beyond == 1 else np.hypot(a0, v / beyond)
        values: Array = getattr(contact.solved(inside, contact.plan(inside, accuracy / 4)), name)
        return values if beyond == 1 else values * beyond ** _power(v, values)

    return at


def _power(v: Array, values: Array) -> float:
    """The power of v = sqrt(a^2 - a0^2) with which a response goes on beyond its last two points; of one alone, the
    second."""
    ends = np.log(v[-2:]), np.log(values[-2:])
    return float(np.diff(ends[1])[0] / np.diff(ends[0])[0]) if v.size > 1 else 2.0


def first_stiffness(contact: Contact, tolerance: float) -> float:
    """S at first touch [N/m]: that of a flat punch of the radius a0, 0 for round and pointed indenters."""
    radii = np.array([contact.indenter.a0])
    return float(contact.solved(radii, contact.plan(radii, tolerance)).S[0]) if radii[0] > 0 else 0.0


def series_of(result: ContactResult, errors: Array, a0: float, S0: float) -> Series:
    """The series of a ``result`` with relative ``errors`` (radii,) or, one row for each of ``COLUMNS``, (4, radii)."""
    radii = result.panels.radii
    columns = dict(zip(COLUMNS, result.columns, strict=True))
    absolute = dict(zip(COLUMNS, errors * result.columns, strict=True))
    return Series(radii, **columns, errors=absolute | {"a": 0 * radii}, a0=a0, S0=S0)


def tolerance_remedy(method: str, error: float) -> str:
    """Advice to accept the relative ``error`` that was reached, empty where no such tolerance is allowed."""
    return f"set {method}.tolerance to {2 * error:.0e}, or " if 2 * error <= LOOSEST else ""
