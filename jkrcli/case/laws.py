"""Tables of laws, one model per registered law: of E over depth, and of relaxation over time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, model_validator

from ..base import Registry, did_you_mean
from ..bodies import LAWS, RELAXATIONS
from .fields import NUMBER, BuiltTable, Modulus, either, findings, table_of, wrong


class LawTable(BuiltTable):
    """The parameters of a ``law``."""

    law: str

    @model_validator(mode="after")
    def _usable(self) -> Self:
        with findings("relaxation"):
            self.built(1.0)
        return self


def _any_law(laws: Registry, check: Callable[[Any], Any], tag_of: Callable[[Any], str], *others: Any) -> Any:
    """The type of any of the ``laws``, or of ``others``; ``check`` sees the data first."""
    tables = (table_of(laws, name, LawTable, law=(Literal.__getitem__(name), name)) for name in laws)
    return Annotated[either(tag_of, *others, *tables), BeforeValidator(check)]


def _modulus(value: Any) -> Any:
    """A table that names no known law is refused before its other keys are checked."""
    if isinstance(value, dict) and not {"law", "depth"} & set(value):
        raise wrong(f"needs a law, one of {', '.join(LAWS)}, got keys {', '.join(value) or 'none'}")
    if isinstance(value, dict) and str(value.get("law", "table")) not in LAWS:
        hint = did_you_mean(value["law"], LAWS)
        raise wrong(f'law must be one of {", ".join(LAWS)}, got "{value["law"]}"{hint}')
    return value


def _relaxation(value: Any) -> Any:
    if not isinstance(value, dict | LawTable):
        raise wrong(f'must be a table, such as {{ law = "sls", ratio = 0.25, time = "1 s" }}, got {value}')
    if isinstance(value, dict) and (name := str(value.get("law", "none"))) not in RELAXATIONS:
        raise wrong(f"law must be one of {', '.join(RELAXATIONS)}, got {name}{did_you_mean(name, RELAXATIONS)}")
    return value


ModulusOrLaw = _any_law(
    LAWS, _modulus, lambda value: str(value.get("law", "table")) if isinstance(value, dict) else NUMBER, Modulus
)
AnyRelaxation = _any_law(RELAXATIONS, _relaxation, lambda value: str(value["law"]))
