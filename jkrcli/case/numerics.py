"""From the numerical tables of a case to configured methods."""

from __future__ import annotations

from ..methods import Method, method_class
from .models import CaseModel


def method_of(model: CaseModel, name: str) -> Method:
    """The method called ``name`` with the options that the case gives it."""
    match name:
        case "layered":
            return method_class(name)(tolerance=model.layered.tolerance)
        case "fem":
            return method_class(name)(contact=model.contact.algorithm, **model.mesh.model_dump(exclude_none=True))
    return method_class(name)()
