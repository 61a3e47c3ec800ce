"""From the numerical tables of a case to configured methods."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..methods import Method, method_class
from .models import CaseModel

if TYPE_CHECKING:
    from ..methods.fem.method import FEM


def method_of(model: CaseModel, name: str) -> Method:
    """The method called ``name`` with the options that the case gives it."""
    match name:
        case "layered":
            return method_class(name)(tolerance=model.layered.tolerance)
        case "hybrid":
            return method_class(name)(tolerance=model.hybrid.tolerance)
        case "fem":
            return fem_of(model)
    return method_class(name)()


def fem_of(model: CaseModel) -> FEM:
    """The finite-element method as the tables mesh and contact say."""
    from ..methods.fem.method import FEM

    return FEM(contact=model.contact.algorithm, **model.mesh.model_dump(exclude_none=True))
