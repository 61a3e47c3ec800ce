"""Contact radii for any loading, for every method that solves the contact equation."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ...bodies.indenters import Indenter
from ...bodies.problem import Loading, Quantity
from ..radii import Response, Responses, half_space_guess, largest_of_loading, radii_of_loading
from .contact import Plan
from .solver import Nested

Array = np.ndarray
ROUGH = 1e-5  # accuracy of the first part of every search


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

    def plan(self, radii: Array, tolerance: float) -> Plan: ...

    def nested(self, radii: Array, plan: Plan) -> Nested: ...


def radii_for_contact(contact: Contact, loading: Loading, accuracy: float) -> Array:
    """All contact radii [m] that ``loading`` asks for; depths and loads are met to the relative ``accuracy``."""
    accuracies = (max(ROUGH, accuracy), accuracy)
    return radii_of_loading(loading, contact.indenter, _responses(contact), _guess(contact, loading), accuracies)


def largest_for_contact(contact: Contact, loading: Loading, accuracy: float) -> float:
    """The contact radius [m] at which ``loading`` ends."""
    accuracies = (max(ROUGH, accuracy), accuracy)
    return largest_of_loading(loading, contact.indenter, _responses(contact), _guess(contact, loading), accuracies)


def _guess(contact: Contact, loading: Loading) -> float:
    return half_space_guess(loading, contact.indenter, contact.E_star, contact.scale)


def _responses(contact: Contact) -> Responses:
    return lambda quantity, accuracy: _response(contact, quantity, accuracy)


def _response(contact: Contact, to: Quantity, accuracy: float) -> Response:
    """delta_H or P_H at given radii, with a quadrature planned for ``accuracy``."""
    name = {"depth": "delta", "load": "P"}[to]

    def response(radii: Array) -> Array:
        beyond = max(float(radii[-1]) / contact.limit, 1.0)  # the response goes on like the square of the radius
        inside = radii / beyond
        return beyond**2 * getattr(contact.nested(inside, contact.plan(inside, accuracy / 4)), name)

    return response
