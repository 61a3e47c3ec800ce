"""The tables of a case file as models: types, ranges, defaults; and from there to the problem."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Annotated, Any, Literal, Self, cast, get_args

from pydantic import (
    BeforeValidator,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    create_model,
    model_validator,
)

from ..bodies import NO_FINITE_RANGE, SHAPES, Loading, Problem, Quantity, Rigid, Specimen
from ..formulas.capillary import capillary, kelvin_radius
from ..methods import METHODS, Descriptor
from ..series import Record
from .fields import (
    Force,
    Length,
    Modulus,
    Table,
    Tension,
    Work,
    as_tuple,
    findings,
    one_or_more,
    quantity,
    readable,
    with_others,
    wrong,
)
from .indenter import IndenterTable, any_indenter
from .laws import AnyRelaxation
from .materials import AnyHalfSpace, AnyLayer

GOALS: tuple[Quantity, ...] = ("depth", "load", "radius")


class SpecimenTable(Table):
    """Layers from the contact surface down on a rigid ``base`` (bonded, if left out), or on an elastic
    ``half_space`` (alone: no layers).

    ``radius`` and ``side`` (its support) make it a cylinder; left out: it is wide. ``surface_tension``: of the solid,
    all over its top. ``surface``: what its points do that the indenter touches. ``relaxation``: all moduli, the
    half-space's too, relax by one function of time; E is the instant modulus.
    """

    layers: Annotated[tuple[AnyLayer, ...], BeforeValidator(as_tuple)] = ()
    base: Literal["bonded", "frictionless"] | None = None
    half_space: AnyHalfSpace | None = None
    radius: Length | None = None
    side: Literal["free", "roller", "clamped"] | None = None
    surface_tension: Tension = 0.0
    surface: Literal["sliding", "sticking"] = "sliding"
    relaxation: AnyRelaxation | None = None

    @model_validator(mode="wrap")
    @classmethod
    def _complete(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        return with_others(cls._finding(data) if isinstance(data, dict) else None, data, handler)

    @staticmethod
    def _finding(keys: Mapping[str, Any]) -> str | None:
        """What is wrong with the choice of keys."""
        if "half_space" in keys and "base" in keys:
            return "give either base (rigid) or half_space (elastic) below the layers, got both"
        if not keys.get("layers") and "half_space" not in keys:
            return "is empty: give [specimen.half_space] with E and nu, or [[specimen.layers]]"
        if "half_space" in keys and ("radius" in keys or "side" in keys):
            return "a cylinder (radius and side) stands on a rigid base: leave out half_space"
        if ("radius" in keys) != ("side" in keys):
            return "a cylinder needs both radius and side (free, roller or clamped), leave both out for a wide body"
        return None

    @model_validator(mode="after")
    def _of_use(self) -> Self:
        with findings():
            self.build()
        return self

    def build(self) -> Specimen:
        base = Rigid(self.base != "frictionless") if self.half_space is None else self.half_space.build()
        layers = tuple(table.build() for table in cast(Any, self.layers))
        relaxation = None if self.relaxation is None else self.relaxation.built()
        return Specimen(layers, base, self.radius, self.side, self.surface_tension, relaxation)


class LoadingTable(Table):
    """One of depth, load, radius: its largest value (``points`` of them), or a list of values; one in brackets is a
    list where nothing says how many.

    ``spacing``: even steps of the contact radius or of the depth, or radii that crowd towards first contact ("log").
    """

    depth: one_or_more(Length) | None = None
    load: one_or_more(Force) | None = None
    radius: one_or_more(Length) | None = None
    points: Annotated[int, Field(ge=1, le=100_000)] = 100
    spacing: Literal["radius", "depth", "log"] = "radius"

    @model_validator(mode="wrap")
    @classmethod
    def _one(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        goals = [name for name in GOALS if name in data] if isinstance(data, dict) else list(GOALS[:1])
        finding = f"needs exactly one of depth, load, radius, got {' and '.join(goals) or 'none'}"
        alone = isinstance(data, dict) and all(isinstance(data[name], list) and len(data[name]) == 1 for name in goals)
        if alone and not {"points", "spacing"} & data.keys():
            data = data | {"points": 1}
        return with_others(None if len(goals) == 1 else finding, data, handler)

    @model_validator(mode="after")
    def _usable(self) -> Self:
        goals = [name for name in GOALS if getattr(self, name) is not None]
        if len(goals) != 1:
            return self  # reported by the rule above
        values = getattr(self, goals[0])
        if not values:
            raise wrong(f"{goals[0]} is an empty list")
        if any(b <= a for a, b in itertools.pairwise(values)):
            raise wrong(f"the values of {goals[0]} must increase, got {list(values)}")
        if len(values) > 1 and (self.points, self.spacing) != (100, "radius"):
            raise wrong(f"a list of {goals[0]} values goes without points and spacing")
        return self

    def build(self) -> Loading:
        quantity, values = next((name, v) for name in GOALS if (v := getattr(self, name)) is not None)
        if len(values) > 1 or self.points == 1:
            return Loading.given(quantity, values)
        return Loading(quantity, values[0], self.points, self.spacing)


class CapillaryTable(Table):
    """A bridge of liquid at fixed humidity (``formulas.capillary``): one of ``humidity`` (of water, from 0 to 1) or
    the radius ``kelvin_radius``.

    ``contact_angles`` in degrees, below 90: one for both surfaces, or one of each.
    """

    surface_tension: Work
    humidity: quantity("number", above=0.0, below=1.0) | None = None
    kelvin_radius: Length | None = None
    contact_angles: one_or_more(quantity("number", least=0.0, below=90.0))

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.humidity is None) == (self.kelvin_radius is None):
            raise wrong("needs one of humidity and kelvin_radius")
        if len(self.contact_angles) not in (1, 2):
            raise wrong(f"contact_angles: must be one or two angles, got {len(self.contact_angles)}")
        if self.surface_tension == 0:
            raise wrong("surface_tension: must be > 0 N/m, got 0")
        return self

    @property
    def bridge(self) -> tuple[float, float]:
        """Tension [Pa] and work of adhesion [J/m^2]."""
        radius = self.kelvin_radius or kelvin_radius(self.surface_tension, self.humidity or math.nan)
        first, last = (math.radians(angle) for angle in (self.contact_angles[0], self.contact_angles[-1]))
        return capillary(self.surface_tension, radius, (first, last))


class AdhesionTable(Table):
    """Work(s) of adhesion and the interatomic distance z0 of the Tabor number; used by transformations only.

    ``range`` or ``stress``: adhesion of finite range, a constant tension up to a separation; ``capillary``: the same by
    a bridge of liquid, which gives the work of adhesion too.
    """

    w: one_or_more(Work) = ()
    z0: Length = Record.z0
    range: Length | None = None
    stress: Modulus | None = None
    capillary: CapillaryTable | None = None

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len(set(self.w)) < len(self.w):
            raise wrong(f"w: holds a value twice, got {list(self.w)}")
        laws = [name for name in ("range", "stress", "capillary") if getattr(self, name) is not None]
        if len(laws) > 1:
            raise wrong(f"give at most one of range, stress and capillary, got {' and '.join(laws)}")
        if laws and laws != ["capillary"] and not all(self.w):
            raise wrong(f"{laws[0]}: goes with works of adhesion > 0, got w = 0")
        if self.capillary is not None and self.w:
            raise wrong("capillary: gives the work of adhesion itself: leave out w")
        return self

    @property
    def works(self) -> tuple[float, ...]:
        """Works of adhesion [J/m^2]: those given, or that of the bridge."""
        return self.w if self.capillary is None else (self.capillary.bridge[1],)

    @property
    def tension(self) -> float | None:
        """The stress given, or that of the bridge [Pa]."""
        return self.stress if self.capillary is None else self.capillary.bridge[0]


class RootTable(Table):
    """A whole file."""

    @classmethod
    def keys_at(cls, path: tuple[str, ...]) -> list[str]:
        """The keys allowed in the table at ``path`` (without list indices, with the tag of a shape or material); what
        is neither key nor tag is the user's name for one of several alike."""
        tables: list[type[Table]] = [cls]
        for part in path:
            if part in tables[0].model_fields:
                tables = list(_tables_in(tables[0].model_fields[part].annotation))
            else:
                tables = [table for table in tables if part.strip("<>") == table.tag] or tables
        return list(dict.fromkeys(key for table in tables for key in table.allowed_keys()))


class CaseModel(RootTable):
    """A whole case file: indenter, specimen, loading, adhesion, and the method with its tables.

    Its shapes, methods and their tables are those that are registered: ``case_model`` completes it.
    """

    title: str = ""
    method: str = "auto"
    indenter: IndenterTable
    specimen: SpecimenTable
    loading: LoadingTable
    adhesion: AdhesionTable = AdhesionTable()

    @model_validator(mode="after")
    def _derived(self) -> Self:
        if self.specimen.surface_tension or self.specimen.relaxation is not None:
            with findings():
                self.problem()
        if self.specimen.surface_tension and (self.adhesion.range or self.adhesion.stress or self.adhesion.capillary):
            raise wrong(f"adhesion: {NO_FINITE_RANGE}")
        return self

    def problem(self) -> Problem:
        """The physics of the case."""
        sticks = self.specimen.surface == "sticking"
        return Problem(self.indenter.build(), self.specimen.build(), self.loading.build(), sticks)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by value: the completed model has no name of its own."""
        return _restored, (self.model_dump(exclude_none=True),)


def case_model(tree: Mapping[str, Any]) -> type[CaseModel]:
    """The model of the case file of the tables ``tree`` with the registered methods; of the shapes of indenters with
    the one that is named there, or with all where it is none of them: models are dear to make."""
    indenter = tree.get("indenter")
    named = indenter.get("shape") if isinstance(indenter, dict) else None
    shapes = {named: SHAPES[named]} if isinstance(named, str) and named in SHAPES else dict(SHAPES)
    return _completed(tuple(shapes.items()), tuple(METHODS.values()))


def _restored(tree: dict[str, Any]) -> CaseModel:
    return case_model(tree).model_validate(tree)


@cache
def _completed(shapes: tuple[tuple[str, Any], ...], methods: tuple[Descriptor, ...]) -> type[CaseModel]:
    names = Literal.__getitem__(("auto", *(method.name for method in methods)))
    fields: dict[str, Any] = {"method": (names, "auto"), "indenter": (any_indenter(dict(shapes)), ...)}
    fields |= {table: (kind, _default(kind)) for table, kind in _option_tables(methods).items()}
    return create_model("CaseModel", __base__=CaseModel, **fields)


def _default(kind: type[Table]) -> Table:
    """The table without any keys. A default that its own method refuses is that method's mistake, which reports it
    when it is used."""
    try:
        return kind()
    except ValidationError:
        return kind.model_construct()


def other_tables(method: str) -> set[str]:
    """The tables of options that the method called ``method`` has no part in."""
    own = {place.table for place in METHODS[method].places.values()} if method in METHODS else set()
    return {place.table for other in METHODS.values() for place in other.places.values()} - own


def _option_tables(methods: Iterable[Descriptor]) -> dict[str, type[Table]]:
    """The tables of the methods' options, those of the method with most of them first."""
    keys: dict[str, dict[str, Any]] = {}
    owners: dict[str, Descriptor] = {}
    for method in sorted(methods, key=lambda method: (-len(method.places), method.effort)):
        for place in method.places.values():
            keys.setdefault(place.table, {})[place.key] = (readable(place.annotation), place.default)
            owners[place.table] = method
    return {table: _option_table(table, keys[table], owners[table]) for table in keys}


def _option_table(table: str, keys: dict[str, Any], method: Descriptor) -> type[Table]:
    """The table named ``table``; its keys together are what the method's options accept."""

    def accepted(self: Table) -> Table:
        options = {name: getattr(self, place.key) for name, place in method.places.items() if place.table == table}
        with findings(table):
            cast(Any, method.options)(**options)
        return self

    check: Any = model_validator(mode="after")(accepted)
    return create_model(table, __base__=Table, __validators__={"accepted": check}, **keys)


def _tables_in(annotation: Any) -> Iterator[type[Table]]:
    """The table models that occur in a type annotation."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for part in get_args(annotation):
        yield from _tables_in(part)
