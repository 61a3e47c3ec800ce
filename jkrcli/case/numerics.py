"""Configured methods from the numerical tables of a case."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..methods import METHODS, Method, method_class
from .models import CaseModel

if TYPE_CHECKING:
    from ..methods import FEM


def method_of(model: CaseModel, name: str) -> Method:
    """The method called ``name`` with the options that the case gives it."""
    return method_class(name)(**options_of(model, name))


def fem_of(model: CaseModel) -> FEM:
    """The finite-element method as the case's tables say."""
    return method_class("fem")(**options_of(model, "fem"))


def options_of(model: CaseModel, name: str) -> dict[str, Any]:
    """The options of the method called ``name`` that the case gives, or that have a default."""
    values = {option: getattr(getattr(model, place.table), place.key) for option, place in METHODS[name].places.items()}
    return {option: value for option, value in values.items() if value is not None}
