"""The tables of a case file as models: types, ranges, defaults; and from there to the problem."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BeforeValidator, Field, model_validator

from ..bodies.problem import HalfSpace, Loading, Problem, Quantity, Rigid, Specimen
from .fields import Force, Length, Table, Work, as_tuple, one_or_more, quantity, wrong
from .indenter import AnyIndenter
from .materials import AnyHalfSpace, AnyLayer


class SpecimenTable(Table):
    """Layers from the contact surface down on a rigid ``base``, or on an elastic ``half_space`` (alone: no layers).

    ``radius`` and ``side`` (its support) make it a cylinder; left out: it is wide.
    """

    layers: Annotated[tuple[AnyLayer, ...], BeforeValidator(as_tuple)] = ()
    base: Literal["bonded", "frictionless"] | None = None
    half_space: AnyHalfSpace | None = None
    radius: Length | None = None
    side: Literal["free", "roller", "clamped"] | None = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if self.half_space is not None and self.base is not None:
            raise wrong("give either base (rigid) or half_space (elastic) below the layers, got both")
        if not self.layers and self.half_space is None:
            raise wrong("is empty: give [specimen.half_space] with E and nu, or [[specimen.layers]]")
        if self.half_space is not None and (self.radius is not None or self.side is not None):
            raise wrong("a cylinder (radius and side) stands on a rigid base: leave out half_space")
        if (self.radius is None) != (self.side is None):
            raise wrong(
                "a cylinder needs both radius and side (free, roller or clamped), leave both out for a wide body"
            )
        return self

    def build(self) -> Specimen:
        base = Rigid(self.base != "frictionless") if self.half_space is None else HalfSpace(self.half_space.material)
        return Specimen(tuple(table.build() for table in self.layers), base, self.radius, self.side)


class LoadingTable(Table):
    """One of depth, load, radius: its largest value (``points`` of them, by ``spacing``), or a list of values."""

    depth: one_or_more(Length) | None = None
    load: one_or_more(Force) | None = None
    radius: one_or_more(Length) | None = None
    points: Annotated[int, Field(ge=1, le=100_000)] = 100
    spacing: Literal["radius", "depth", "log"] = "radius"

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [name for name in ("depth", "load", "radius") if getattr(self, name) is not None]
        if len(given) != 1:
            raise wrong(f"needs exactly one of depth, load, radius, got {' and '.join(given) or 'none'}")
        values = getattr(self, given[0])
        if not values:
            raise wrong(f"{given[0]} is an empty list")
        if any(b <= a for a, b in itertools.pairwise(values)):
            raise wrong(f"the values of {given[0]} must increase, got {list(values)}")
        if len(values) > 1 and (self.points, self.spacing) != (100, "radius"):
            raise wrong(f"a list of {given[0]} values goes without points and spacing")
        return self

    def build(self) -> Loading:
        goals: tuple[Quantity, ...] = ("depth", "load", "radius")
        quantity, values = next((name, v) for name in goals if (v := getattr(self, name)) is not None)
        if len(values) > 1:
            return Loading.given(quantity, values)
        return Loading(quantity, values[0], self.points, self.spacing)


class AdhesionTable(Table):
    """Work(s) of adhesion and the interatomic distance z0 of the Tabor number; used by transformations only."""

    w: one_or_more(Work) = ()
    z0: Length = 0.3e-9

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len(set(self.w)) < len(self.w):
            raise wrong(f"w: holds a value twice, got {list(self.w)}")
        return self


ThreeNumbers = Annotated[
    tuple[quantity("number", above=0), quantity("number", above=0), quantity("number", above=0)],
    BeforeValidator(as_tuple),
]


class MeshTable(Table):
    """The finite-element mesh; everything has a default (left out: chosen from the problem)."""

    layout: Literal["scaled", "zones"] = "scaled"
    element: Literal["triangle", "quadrilateral"] = "triangle"
    order: Literal[1, 2] = 2
    formulation: Literal["auto", "displacement", "mixed"] = "auto"
    element_size: Length | None = None
    zone_sizes: ThreeNumbers = (0.02, 0.05, 0.5)
    depth: Length | None = None
    width: Length | None = None
    contact_radius: Length | None = None
    spacing: quantity("number", above=0, below=0.5) = 0.04
    smallest: quantity("number", above=0, below=1) = 0.05
    growth: quantity("number", above=0, below=0.6) | None = None
    margin: quantity("number", above=1, below=10) = 1.1
    edge_correction: bool = True
    estimate_error: bool = True
    tolerance: quantity("number", least=1e-6, most=0.1) | None = None
    solver: Literal["auto", "superlu", "cholmod"] = "auto"

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        if self.element_size is not None and self.layout == "scaled":
            raise wrong('element_size belongs to layout "zones"; the layout "scaled" takes spacing')
        if self.tolerance is not None and (self.layout == "zones" or not self.estimate_error):
            raise wrong('tolerance needs the layout "scaled" and estimate_error = true')
        return self


class ContactTable(Table):
    algorithm: Literal["nested", "incremental"] = "nested"


class LayeredTable(Table):
    tolerance: quantity("number", least=1e-12, most=1e-2) = 1e-8


class HybridTable(Table):
    tolerance: quantity("number", least=1e-8, most=1e-2) = 1e-5


class RootTable(Table):
    """A whole file."""

    @classmethod
    def keys_at(cls, path: tuple[str, ...]) -> list[str]:
        """The keys allowed in the table at ``path`` (without list indices, with the tag of a shape or material)."""
        tables: list[type[Table]] = [cls]
        for part in path:
            if part in tables[0].model_fields:
                tables = list(_tables_in(tables[0].model_fields[part].annotation))
            else:
                tables = [table for table in tables if part in table.tags()]
        keys = [key for table in tables for key in table.model_fields]
        return [*keys, "file"] if path == ("indenter", "table") else list(dict.fromkeys(keys))


class CaseModel(RootTable):
    """A whole case file. Physics: indenter, specimen, loading, adhesion; numerics: method, mesh, contact, layered."""

    title: str = ""
    method: Literal["auto", "closed-form", "layered", "hybrid", "fem"] = "auto"
    indenter: AnyIndenter
    specimen: SpecimenTable
    loading: LoadingTable
    adhesion: AdhesionTable = AdhesionTable()
    mesh: MeshTable = MeshTable()
    contact: ContactTable = ContactTable()
    layered: LayeredTable = LayeredTable()
    hybrid: HybridTable = HybridTable()

    def problem(self) -> Problem:
        """The physics of the case."""
        return Problem(self.indenter.build(), self.specimen.build(), self.loading.build())


def _tables_in(annotation: Any) -> Iterator[type[Table]]:
    """The table models that occur in a type annotation."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for part in get_args(annotation):
        yield from _tables_in(part)
