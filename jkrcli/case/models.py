"""A case: its TOML file, the tables of that as models (types, ranges, defaults), and from there to the problem."""

import contextlib
import functools
import itertools
import math
import operator
import re
import tomllib
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import tomli_w
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    ModelWrapValidatorHandler,
    Tag,
    ValidationError,
    ValidationInfo,
    create_model,
    model_validator,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError
from pydantic_core.core_schema import no_info_before_validator_function

from ..base import units
from ..base.arguments import checked, ranges_of
from ..base.errors import InputError, counted, did_you_mean, nearest
from ..base.files import read_bytes
from ..base.registry import Registry
from ..base.units import Ranged, doubtful_work
from ..base.wings import absent
from ..bodies.indenters import SHAPES, Indenter
from ..bodies.problem import (
    LAWS,
    NO_FINITE_RANGE,
    RELAXATIONS,
    Coated,
    Elastic,
    Graded,
    GradedTransverselyIsotropic,
    HalfSpace,
    Law,
    Layer,
    Loading,
    Material,
    Problem,
    Quantity,
    Rigid,
    Solid,
    Specimen,
    TransverselyIsotropic,
)
from ..formulas import capillary, kelvin_radius
from ..methods.protocol import METHODS, Descriptor, InTable, Method, method_class
from ..series import Record
from ..tables import split_name, unit_power

TYPE_CHECKING = False
if TYPE_CHECKING:
    from ..tables.text import TextTable

# --------------------------------------------------------------------------------------------------
# Building blocks of the case tables: types that read numbers with dimension and range, and the strict table itself.

Made = TypeVar("Made")
NUMBER = "number"  # tag of what is no table


def wrong(message: str) -> PydanticCustomError:
    """A finding in our own words; braces would be taken as a template."""
    return PydanticCustomError("jkr", "{message}", {"message": message})


@contextlib.contextmanager
def findings(table: str = "") -> Iterator[None]:
    """The lines of an InputError within, led by the name of the ``table`` or not, become findings on it."""
    try:
        yield
    except InputError as error:
        raise wrong(str(error).removeprefix(f"{table}: ")) from None


def with_others(finding: str | None, data: Any, handler: Callable[[Any], Made]) -> Made:
    """The table that ``handler`` makes of ``data``; a ``finding`` on its choice of keys is reported together with what
    else is wrong, unless an unknown key may be the reason."""
    if finding is None:
        return handler(data)
    items: list[Any] = []
    try:
        handler(data)
    except ValidationError as error:
        items = error.errors()
    unknown = any(item["type"] == "extra_forbidden" and len(item["loc"]) == 1 for item in items)
    found = [] if unknown else [InitErrorDetails(type=wrong(finding), input=data)]
    for item in items:  # pydantic takes findings in another form than it gives them
        kind = wrong(item["msg"]) if item["type"] == "jkr" else item["type"]
        found.append(InitErrorDetails(type=kind, loc=item["loc"], input=item["input"], ctx=item.get("ctx", {})))
    raise ValidationError.from_exception_data("table", found)


def readable(annotation: Any) -> Any:
    """The type that reads ``annotation`` from a file: numbers by their ``Ranged``, tuples from lists."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        notes = [Read(note) for note in annotation.__metadata__ if isinstance(note, Ranged)]
        return Annotated[(readable(parts[0]), *notes)] if notes else readable(parts[0])
    if origin is tuple:
        return Annotated[tuple[tuple(map(readable, parts))], BeforeValidator(as_tuple)]
    if origin in (Union, types.UnionType):
        return functools.reduce(operator.or_, map(readable, parts))
    return annotation


@dataclass(frozen=True)
class Read:
    """Reads a number of a case file by its ``ranged``; stands in ``Annotated``."""

    ranged: Ranged

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_before_validator_function(self.read, handler(source))

    def read(self, value: Any) -> float:
        """The SI value."""
        try:
            return self.ranged.read(value)
        except ValueError as error:
            raise wrong(str(error)) from None


def quantity(dimension: str, **bounds: Any) -> Any:
    """A finite number of ``dimension``, SI or text with a unit, within the ``bounds`` of ``Ranged``."""
    return readable(Annotated[float, Ranged(dimension, **bounds)])


Length, AnyLength, Modulus, Force, Work, Tension, Poisson = map(
    readable, (units.Length, units.AnyLength, units.Modulus, units.Force, units.Work, units.Tension, units.Poisson)
)


def as_tuple(value: Any) -> Any:
    """TOML lists become tuples; anything else is left for the type check."""
    return tuple(value) if isinstance(value, list) else value


def as_several(value: Any) -> Any:
    """A single value is a tuple of one."""
    return as_tuple(value) if isinstance(value, list | tuple) else (value,)


def one_or_more(kind: Any) -> Any:
    """A tuple of ``kind``; a single value in the file is a tuple of one."""
    return Annotated[tuple[kind, ...], BeforeValidator(as_several)]


class Table(BaseModel):
    """A table of the case file: strict types, no unknown keys, frozen."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)
    tag: ClassVar[str] = ""  # tells it apart from others that may stand in its place

    @classmethod
    def allowed_keys(cls) -> list[str]:
        """The keys that a file may hold here."""
        return [field.alias or name for name, field in cls.model_fields.items()]


def either(tag_of: Callable[[Any], str], *kinds: Any) -> Any:
    """The type of one of several tables, or a number: ``tag_of`` says by which tag data are read."""

    def tag(value: Any) -> str:
        return f"<{value.tag if isinstance(value, Table) else tag_of(value)}>"

    tagged = (Annotated[kind, Tag(f"<{getattr(kind, 'tag', NUMBER)}>")] for kind in kinds)
    return Annotated[functools.reduce(operator.or_, tagged), Discriminator(tag)]


class BuiltTable(Table):
    """A table whose keys are the parameters of what builds it: ``table_of`` makes the model."""

    builder: ClassVar[Callable[..., Any]]
    parameters: ClassVar[dict[str, str]] = {}  # of the builder, by key
    inherited: ClassVar[str | None] = None  # its parameter that the table around passes on

    def built(self, inherited: Any = None) -> Any:
        """What the table describes; InputError where its keys do not go together."""
        values = {parameter: getattr(self, key) for key, parameter in self.parameters.items()}
        return type(self).builder(**values | ({self.inherited: inherited} if self.inherited else {}))


def table_of(registry: Registry, name: str, base: type[BuiltTable], **keys: Any) -> Any:
    """The model of the table of what ``registry`` calls ``name``, with more ``keys`` (type, default) than its own."""
    parameters = registry.parameters(name)
    inherited = parameters.pop(registry.inherited, None)
    keys |= {key: (readable(item.annotation), item.default) for key, item in parameters.items()}
    table = create_model(name, __base__=base, **keys)
    table.tag, table.builder = name, staticmethod(registry[name])
    table.inherited = inherited.name if inherited else None
    table.parameters = {key: item.name for key, item in parameters.items()}
    return table


# --------------------------------------------------------------------------------------------------
# Tables of laws, one model per registered law: of E over depth, and of relaxation over time.


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
        raise wrong(f"must name one law of {', '.join(LAWS)}, got keys {', '.join(value) or 'none'}")
    if isinstance(value, dict) and str(value.get("law", "table")) not in LAWS:
        hint = did_you_mean(value["law"], LAWS)
        raise wrong(f'law must be one of {", ".join(LAWS)}, got "{value["law"]}"{hint}')
    return value


def _relaxation(value: Any) -> Any:
    if not isinstance(value, dict | LawTable):
        raise wrong(f'must be a table, such as {{ law = "sls", ratio = 0.25, time = "1 s" }}, got {value}')
    if isinstance(value, dict) and (name := str(value.get("law", "none"))) not in RELAXATIONS:
        laws = RELAXATIONS
        raise wrong(f"law must be one of {', '.join(laws)}, got {name}{did_you_mean(name, laws)}")
    return value


ModulusOrLaw = _any_law(
    LAWS,
    _modulus,
    lambda value: str(value.get("law", "table")) if isinstance(value, dict) else NUMBER,
    Modulus,
)
AnyRelaxation = _any_law(RELAXATIONS, _relaxation, lambda value: str(value["law"]))


# --------------------------------------------------------------------------------------------------
# Layers and half-spaces: homogeneous, graded over depth, or transversely isotropic.


class _Part(Table):
    @model_validator(mode="after")
    def _usable(self) -> Self:
        with findings():
            self.build()
        return self

    def build(self) -> Layer | HalfSpace:
        return HalfSpace(self.material(math.inf))

    def material(self, thickness: float) -> Any:
        """The material of a part of this ``thickness`` [m]."""
        raise NotImplementedError


class _Layer(_Part):
    thickness: Length
    name: str = ""

    def build(self) -> Layer:
        return Layer(self.material(self.thickness), self.thickness, self.name)


class IsotropicTable(_Part):
    """E, or its law over the depth, and nu."""

    tag: ClassVar[str] = "isotropic"
    E: ModulusOrLaw
    nu: Poisson

    def material(self, thickness: float) -> Elastic | Graded:
        E: Any = self.E
        return Graded(E.built(thickness), self.nu) if isinstance(E, LawTable) else Elastic(E, self.nu)


class TransverseTable(_Part):
    """The five constants of a transversely isotropic material: p in the plane, z along the depth; each modulus, or its
    law over the depth."""

    tag: ClassVar[str] = "transverse"
    E_p: ModulusOrLaw
    E_z: ModulusOrLaw
    nu_p: quantity("number", above=-1, below=1)
    nu_zp: quantity("number")
    G_z: ModulusOrLaw

    def material(self, thickness: float) -> TransverselyIsotropic | GradedTransverselyIsotropic:
        given: list[Any] = [self.E_p, self.E_z, self.nu_p, self.nu_zp, self.G_z]
        if not any(isinstance(one, LawTable) for one in given):
            return TransverselyIsotropic(*given)
        values = (one.built(thickness) if isinstance(one, LawTable) else one for one in given)
        return GradedTransverselyIsotropic(*values)


class LayerTable(_Layer, IsotropicTable): ...


class TransverseLayerTable(_Layer, TransverseTable): ...


def _homogeneous(why: str) -> BeforeValidator:
    """Refuse a law of the modulus over the depth, because of ``why``."""

    def one_modulus(value: Any) -> Any:
        if isinstance(value, dict):
            raise wrong(why)
        return value

    return BeforeValidator(one_modulus)


ModulusOfHalfSpace = Annotated[
    Modulus,
    _homogeneous("a half-space is homogeneous: put a graded layer on it, thick enough that the rest does not matter"),
]
ModulusOfCoating = Annotated[
    Modulus, _homogeneous("a layer of the indenter is homogeneous: cut a graded one into several")
]


class CoatingTable(LayerTable):
    E: ModulusOfCoating


class TransverseCoatingTable(TransverseLayerTable):
    E_p: ModulusOfCoating
    E_z: ModulusOfCoating
    G_z: ModulusOfCoating


class HalfSpaceTable(IsotropicTable):
    E: ModulusOfHalfSpace


class TransverseHalfSpaceTable(TransverseTable):
    E_p: ModulusOfHalfSpace
    E_z: ModulusOfHalfSpace
    G_z: ModulusOfHalfSpace


def _tag(value: Any) -> str:
    constants = isinstance(value, dict) and not TransverseTable.model_fields.keys().isdisjoint(value)
    return (TransverseTable if constants else IsotropicTable).tag


AnyLayer = either(_tag, LayerTable, TransverseLayerTable)
AnyCoating = either(_tag, CoatingTable, TransverseCoatingTable)
AnyHalfSpace = either(_tag, HalfSpaceTable, TransverseHalfSpaceTable)


# --------------------------------------------------------------------------------------------------
# The indenter table of a case file: one model per registered shape, made from its keys.

CALLED = {"r": ("r", "radius", "x", "position"), "f": ("f", "z", "height")}  # columns of a profile
MOST_PROFILE_BYTES = 4 << 20  # choice: of a profile's file, a hundred thousand points are read in a second


class IndenterTable(BuiltTable):
    """Keys that every shape has: its name, E and nu of an elastic indenter (left out: rigid), and its homogeneous
    ``layers``, outermost first.

    A shape by lists may be given as a ``file``, a table of text with a column for each: "r (nm)" for the key ``r``.
    """

    E: Modulus | None = None
    nu: Poisson | None = None
    layers: Annotated[tuple[AnyCoating, ...], BeforeValidator(as_tuple)] = ()
    shape: str

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, data: Any, info: ValidationInfo) -> Any:
        lists = cls.lists()
        if not (lists and isinstance(data, dict) and "file" in data):
            return data
        data = dict(data)
        name = data.pop("file")
        if not isinstance(name, str) or any(key in data for key in lists):
            raise wrong(f"give either file or the lists {' and '.join(lists)}")
        folder = (info.context or {}).get("folder") or Path()
        return data | read_columns(folder / name, lists)

    @model_validator(mode="after")
    def _buildable(self) -> Self:
        if (self.E is None) != (self.nu is None):
            raise wrong("an elastic indenter needs both E and nu (leave both out for a rigid one)")
        if self.layers and self.E is None:
            raise wrong(
                "layers are on an elastic core: give E and nu of the core, below them (a stiff one is as rigid)"
            )
        with findings():
            self.build()
        return self

    def build(self) -> Indenter:
        """The indenter of the table."""
        material: Solid | None = None if self.E is None or self.nu is None else Elastic(self.E, self.nu)
        if self.layers and isinstance(material, Elastic):
            material = Coated(tuple(table.build() for table in cast(Any, self.layers)), material)
        return self.built(material)

    @classmethod
    def lists(cls) -> list[str]:
        """Required keys that are lists of lengths."""
        fields = {key: cls.model_fields[key] for key in cls.parameters}
        return [key for key, field in fields.items() if field.is_required() and get_origin(field.annotation) is tuple]

    @classmethod
    def allowed_keys(cls) -> list[str]:
        return [*super().allowed_keys(), *(["file"] if cls.lists() else [])]


def any_indenter(shapes: Iterable[str]) -> Any:
    """The type of the table of any of the registered ``shapes``, distinguished by their names."""
    tables = [table_of(SHAPES, name, IndenterTable, shape=(Literal.__getitem__(name), ...)) for name in shapes]
    union = functools.reduce(operator.or_, tables)
    return Annotated[union, Field(discriminator="shape")] if len(tables) > 1 else union


def read_columns(path: Path, wanted: list[str]) -> dict[str, tuple[float, ...]]:
    """The columns ``wanted``, lengths in m, of a table of text by their names, with a unit in the header or in m."""
    from ..tables.text import read_table

    try:
        content = read_bytes(path, "profile file", MOST_PROFILE_BYTES)
        table = read_table(path, least=len(wanted), content=content)
        chosen = {name: _column(table, name) for name in wanted}
    except InputError as error:
        raise wrong("; ".join(error.lines)) from None
    return {name: tuple((scale * table.values[:, i]).tolist()) for name, (i, scale) in chosen.items()}


def _column(table: "TextTable", name: str) -> tuple[int, float]:
    """Number of the column called ``name`` and its unit in m."""
    titles = [split_name(title) for title in table.names]
    matches = [i for i, (title, _) in enumerate(titles) if title.strip().lower() in CALLED.get(name, (name,))]
    if len(matches) != 1:
        count = "no column" if not matches else f"{len(matches)} columns"
        raise InputError(
            f'{table.path}: {count} "{name}": the header must name r and f with their unit, "r (nm)", "f (nm)" or r_m, '
            f"f_m ({table.choice})"
        )
    unit = titles[matches[0]][1] or "m"
    power = unit_power(unit)
    if power is None or power[0] != "length":
        raise InputError(f'{table.path}: {table.titled(matches[0])}: must be a length, "{name} (nm)"')
    return matches[0], 10.0 ** power[1]


GOALS: tuple[Quantity, ...] = ("depth", "load", "radius")


class SpecimenTable(Table):
    """Layers from the contact surface down on a rigid ``base`` (bonded, if left out), or on an elastic
    ``half_space`` (alone: no layers).

    ``radius`` and ``side`` (its support) make it a cylinder; left out: it is wide. ``surface_tension``: of the solid,
    all over its top. ``surface``: what its points do that the indenter touches. ``relaxation``: all moduli, the
    half-space's too, relax by one function of time; E is the instantaneous modulus.
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
        """The message on keys that exclude or need each other; None where they go together."""
        if "half_space" in keys and "base" in keys:
            return "give either base (rigid) or half_space (elastic) below the layers, got both"
        if not keys.get("layers") and "half_space" not in keys:
            return "is empty: give [specimen.half_space] with E and nu, or [[specimen.layers]]"
        if "half_space" in keys and ("radius" in keys or "side" in keys):
            return "a cylinder (radius and side) stands on a rigid substrate: leave out half_space"
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

    ``spacing``: even steps of the contact radius, the depth or the load, or radii that crowd towards first contact
    ("log").
    """

    depth: one_or_more(Length) | None = None
    load: one_or_more(Force) | None = None
    radius: one_or_more(Length) | None = None
    points: Annotated[int, Field(ge=1, le=100_000)] = 100
    spacing: Literal["radius", "depth", "load", "log"] = "radius"

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
            raise wrong(f"{laws[0]}: needs works of adhesion > 0, got w = 0")
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
    def for_tables(cls, tree: Mapping[str, Any]) -> type[Self]:
        """The model that reads the tables ``tree``: this one, or what is registered beside it."""
        return cls

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

    Its shapes, methods and their tables are those that are registered: ``for_tables`` completes it.
    """

    title: str = ""
    method: str = "auto"
    indenter: IndenterTable
    specimen: SpecimenTable
    loading: LoadingTable
    adhesion: AdhesionTable = AdhesionTable()

    @classmethod
    def for_tables(cls, tree: Mapping[str, Any]) -> type[Self]:
        """The model with the registered methods; of the shapes of indenters with the one that is named in ``tree``, or
        with all where it is none of them: models are dear to make."""
        indenter = tree.get("indenter")
        named = indenter.get("shape") if isinstance(indenter, dict) else None
        shapes = {named: SHAPES[named]} if isinstance(named, str) and named in SHAPES else dict(SHAPES)
        return cast(type[Self], _completed(tuple(shapes.items()), tuple(METHODS.values())))

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


def _restored(tree: dict[str, Any]) -> CaseModel:
    return CaseModel.for_tables(tree).model_validate(tree)


@dataclass(frozen=True)
class Place:
    """Where an option of a method stands in a case file, its annotation and its default."""

    table: str
    key: str
    annotation: Any
    default: Any


@cache
def places(method: Descriptor) -> dict[str, Place]:
    """Where the options of ``method`` stand, by name."""
    if method.options is None:
        return {}
    hints, found = get_type_hints(method.options, include_extras=True), {}
    for item in fields(method.options):
        notes = getattr(hints[item.name], "__metadata__", ())
        elsewhere = [note for note in notes if isinstance(note, InTable)]
        where = elsewhere[0] if elsewhere else InTable(method.table or method.name, item.name)
        found[item.name] = Place(where.table, where.key, hints[item.name], item.default)
    return found


@cache
def _completed(shapes: tuple[tuple[str, Any], ...], methods: tuple[Descriptor, ...]) -> type[CaseModel]:
    names = Literal.__getitem__(("auto", *(method.name for method in methods)))
    tables: dict[str, Any] = {"method": (names, "auto"), "indenter": (any_indenter(dict(shapes)), ...)}
    # The tables of the methods' options, those of the method with most of them first
    keys: dict[str, dict[str, Any]] = {}
    owners: dict[str, Descriptor] = {}
    for method in sorted(methods, key=lambda method: (-len(places(method)), method.effort)):
        for place in places(method).values():
            keys.setdefault(place.table, {})[place.key] = (readable(place.annotation), place.default)
            owners[place.table] = method
    for table in keys:
        kind = _option_table(table, keys[table], owners[table])
        tables[table] = (kind, kind.model_construct())  # a default that its own method refuses is told when it is used
    return create_model("CaseModel", __base__=CaseModel, **tables)


def other_tables(method: str) -> set[str]:
    """The tables of options that the method called ``method`` has no part in."""
    own = {place.table for place in places(METHODS[method]).values()} if method in METHODS else set()
    return {place.table for other in METHODS.values() for place in places(other).values()} - own


def _option_table(table: str, keys: dict[str, Any], method: Descriptor) -> type[Table]:
    """The table named ``table``; its keys together are what the method's options accept."""

    def accepted(self: Table) -> Table:
        options = {name: getattr(self, place.key) for name, place in places(method).items() if place.table == table}
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


# --------------------------------------------------------------------------------------------------
# Configured methods from the numerical tables of a case.


def method_of(model: CaseModel, name: str) -> Method:
    """The method called ``name`` with the options that the case gives it."""
    options = options_of(model, name)
    return method_class(name)(**options)


def options_of(model: CaseModel, name: str) -> dict[str, Any]:
    """The options of the method called ``name`` that the case gives, or that have a default."""
    if name not in METHODS:
        method_class(name)  # which refuses it by its name
    values = {
        option: getattr(getattr(model, place.table), place.key) for option, place in places(METHODS[name]).items()
    }
    return {option: value for option, value in values.items() if value is not None}


# --------------------------------------------------------------------------------------------------
# Numbers with a unit that stand in a TOML file without quotes: ``radius = 10 um``, which is no TOML.

NUMERAL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
UNIT = r"[a-zA-ZµμÅ°][\w/^²*.-]*"
UNQUOTED = re.compile(
    rf"""(?P<key>(?:^|[{{,])[ \t]*[\w."'-]+)[ \t]*=[ \t]*(?P<value>{NUMERAL}[ \t]*{UNIT})[ \t]*(?=[\#,}}]|\r?$)""",
    re.MULTILINE,
)
QUOTES_NUMERAL = re.compile(r"0[xob][0-9a-fA-F_]+")  # TOML's own numbers with letters


MOST_UNQUOTED = 100  # choice: of one file that are told


class UnquotedError(InputError):
    """Values with a unit lack their quotes, one in each of the ``lines``; ``quoted``: the text with them."""

    def __init__(self, source: str, text: str):
        self.quoted = UNQUOTED.sub(_quoted, text)
        super().__init__([
            f"{source}: line {text.count(chr(10), 0, match.start('value')) + 1}: text with a unit must stand in "
            f"quotes: {_quoted(match).strip('{, ')}"
            for match in itertools.islice(UNQUOTED.finditer(text), MOST_UNQUOTED)
            if not QUOTES_NUMERAL.fullmatch(match["value"])
        ])  # fmt: skip


def _quoted(match: re.Match[str]) -> str:
    return match[0] if QUOTES_NUMERAL.fullmatch(match["value"]) else f'{match["key"]} = "{match["value"]}"'


# --------------------------------------------------------------------------------------------------
# Case files: TOML in, validated models out, and back again. Everything that is wrong is reported at once.

Root = TypeVar("Root", bound=RootTable)
MOST_BYTES = 2 << 20  # choice: of a file, read at about 1 MiB/s; 10,000 points of a profile take a fifth of it
MOST_TOLD = 100  # choice: mistakes of one file that are told
MOST_PARTS = 50  # of a dotted key; reading takes the square of it
MANY_PARTS = re.compile(rb"""^[ \t\[]*(?:[\w"'-]+[ \t]*\.[ \t]*){%d}""" % MOST_PARTS, re.MULTILINE)
KINDS = {  # what the file must hold, by pydantic's types of findings
    ("model_type", "dict_type", "model_attributes_type"): "a table",
    ("list_type", "tuple_type"): "a list",
    ("int_type", "int_from_float"): "a whole number",
    ("bool_type",): "true or false",
    ("string_type",): "a text",
}
KeysAt = Callable[[tuple[str, ...]], list[str]]
# Of keys that other tables have, which one of them means
ELSEWHERE = {
    "counter_radius": ': the radius of a spherical specimen needs shape = "paraboloid"; omit it on a flat specimen',
    "specimen.E": ", a half-space is [specimen.half_space] with E and nu, a layer [[specimen.layers]]",
}


@dataclass(frozen=True, eq=False, repr=False)
class Case:
    """A validated case: ``model`` holds the values in SI, ``source`` the file they came from, ``text`` what stands
    there where that is a solution file, ``remarks`` what may not have been meant as it stands."""

    model: CaseModel
    source: str
    text: str = ""
    remarks: tuple[str, ...] = ()

    def with_tolerance(self, tolerance: float, method: str) -> "Case":
        """The case in which ``method`` has this relative error as its tolerance; "auto": every one that can be, as near
        to it as it allows. InputError where no method has it."""
        tree = self.model.model_dump(exclude_none=True)
        ranges = {name: ranges_of(known.options).get("tolerance") for name, known in METHODS.items() if known.options}
        known = {name: ranged for name, ranged in ranges.items() if ranged and method in ("auto", name)}
        if not any(tolerance in ranged for ranged in known.values()):
            allowed = ", ".join(f"{name} takes {ranged.rule}" for name, ranged in known.items())
            allowed = allowed or f"method {method} has none, its formula errs as it does; leave the option out"
            raise InputError(f"--tolerance: {allowed}, got {tolerance:g}")
        for name, ranged in known.items():
            place = places(METHODS[name])["tolerance"]
            table = {place.table: tree.get(place.table, {}) | {place.key: ranged.nearest(tolerance)}}
            try:
                tree |= model_of(tree | table, self.source).model_dump(exclude_none=True)
            except InputError:  # a mesh of given sizes, say, that has no tolerance
                if method == name:
                    raise
        return Case(model_of(tree, self.source), self.source, remarks=self.remarks)

    def to_toml(self, method: str | None = None) -> str:
        """The resolved case, every default written out, SI numbers: reads back to the same numbers. With the options
        of the ``method`` alone where one is named, so that what it made never needs another one."""
        if self.text:
            return self.text
        tree = self.model.model_dump(exclude_none=True, exclude=set() if method is None else other_tables(method))
        if method in METHODS and tree["method"] != "auto":
            tree["method"] = method
        return tomli_w.dumps(tree)


@checked
def load_case(path: str | Path) -> Case:
    """Load and check a case file.

    Parameters
    ----------
    path : path
        The TOML file.

    Returns
    -------
    Case
        To be solved by `solve`, or checked by `check`.

    Raises
    ------
    InputError
        With a line per mistake: file, line, value and what is allowed.
    """
    path = path if isinstance(path, Path) else Path(path)
    return parse_case(read_bytes(path, "case file"), str(path), path.parent)


def parse_case(content: bytes, source: str, folder: Path | None = None) -> Case:
    """Validate the bytes of a case file; ``folder`` is where relative names of profile tables are looked up."""
    try:
        tree = parse_toml(content, source)
    except UnquotedError as error:
        lines = list(error.lines)
        try:  # what else is wrong in the text
            parse_case(error.quoted.encode(), source, folder)
        except InputError as others:
            lines += others.lines
        raise InputError(lines) from None
    if "base" in tree and "indenter" not in tree:
        raise InputError(f"{source}: is a sweep file, not a case: jkr sweep runs it")
    model = model_of(tree, source, folder)
    # A bare number is read as SI: a remark where that makes a work of adhesion that surfaces hardly have
    works = tree.get("adhesion", {}).get("w", [])
    bare = (work for work in (works if isinstance(works, list) else [works]) if not isinstance(work, str))
    remarks = tuple(f"{source}: adhesion.w: {doubt}" for work in bare if (doubt := doubtful_work(work)))
    return Case(model, source, remarks=remarks)


def parse_toml(content: bytes, source: str) -> dict[str, Any]:
    """The tables in the bytes of a TOML file, not yet looked into."""
    if len(content) > MOST_BYTES:
        raise InputError(f"{source}: is larger than {MOST_BYTES >> 20} MiB; put a long profile into a table of its own")
    if many := MANY_PARTS.search(content):
        line = content.count(b"\n", 0, many.start()) + 1
        raise InputError(f"{source}: line {line}: a key must not have more than {MOST_PARTS} parts")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        series = "; for the case of a solution file use jkr show --case" if source.endswith(".h5") else ""
        raise InputError(f"{source}: is not a text file (byte {error.start} is not UTF-8){series}") from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{source}: is not valid TOML: brackets are nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        if (unquoted := UnquotedError(source, text)).lines:
            raise unquoted from None
        raise InputError(f"{source}: is not valid TOML: {str(error)[0].lower()}{str(error)[1:]}") from None
    except ValueError:
        raise InputError(f"{source}: is not valid TOML: a number has thousands of digits") from None


def plain_toml(text: str) -> str:
    """The tables in the TOML ``text`` with characters that steer a terminal written as escapes: it reads back to the
    same values. What holds none of them is left as it is."""
    if all(map(str.isprintable, text.split("\n"))):
        return text
    dumped = tomli_w.dumps(parse_toml(text.encode(), "case"))  # in strings alone, and of those basic ones
    return "".join(c if c.isprintable() or c == "\n" else f"\\U{ord(c):08x}" for c in dumped)


def model_of(tree: dict[str, Any], source: str, folder: Path | None = None) -> CaseModel:
    """The case of the tables ``tree``; InputError with a line per mistake, each led by ``source``."""
    return validated(CaseModel, tree, source, folder)


def validated(kind: type[Root], tree: dict[str, Any], source: str, folder: Path | None = None) -> Root:
    """The tables of a whole file as a model of ``kind``; InputError with a line per mistake, each led by ``source``."""
    model = kind.for_tables(tree)
    try:
        return model.model_validate(tree, context={"folder": folder})
    except ValidationError as error:
        raise InputError([f"{source}: {line}" for line in _sentences(error, tree, model.keys_at)]) from None


def _sentences(error: ValidationError, tree: dict[str, Any], keys_at: KeysAt) -> list[str]:
    """One sentence per mistake, sorted; a missing key that an unknown one is a misspelling of is not reported twice."""
    items = error.errors(include_url=False)
    more = [f"has {counted(len(items) - MOST_TOLD, 'more mistake')}"] if len(items) > MOST_TOLD else []
    items = items[:MOST_TOLD]
    meant = {
        (*item["loc"][:-1], close)
        for item in items
        if item["type"] == "extra_forbidden"
        if (close := nearest(item["loc"][-1], _allowed(item["loc"], keys_at)))
    }
    mistakes = [item for item in items if not (item["type"] == "missing" and item["loc"] in meant)]
    return [*sorted({_sentence(item, tree, keys_at) for item in mistakes}), *more]


def _sentence(item: Any, tree: dict[str, Any], keys_at: KeysAt) -> str:
    """One of pydantic's findings in our words: ``specimen.layers[1].E: must be > 0, got -3 Pa``."""
    where, value, context = _path(item["loc"], tree), item["input"], item.get("ctx", {})
    match item["type"]:
        case "missing":
            infinite = where.startswith("specimen.layers") and where.endswith(".thickness")
            return f"{where}: is required{'; a half-space is [specimen.half_space]' if infinite else ''}"
        case "extra_forbidden":
            if lacking := absent(f"method {where}") or absent(f"table {where}"):
                return f"{where}: {lacking}"
            keys = _allowed(item["loc"], keys_at)
            hint = ELSEWHERE.get(where) or ELSEWHERE.get(str(item["loc"][-1])) or did_you_mean(item["loc"][-1], keys)
            return f"{where}: unknown key{hint} (allowed: {', '.join(keys)})"
        case "literal_error":
            if lacking := absent(f"{where} {value}"):
                return f"{where}: {shown(value)} {lacking}"
            allowed = [str(word).strip("'") for word in context["expected"].replace(" or ", ", ").split(", ")]
            return f"{where}: must be one of {', '.join(allowed)}, got {shown(value)}{did_you_mean(value, allowed)}"
        case "union_tag_not_found":
            return f"{where}.{context['discriminator'].strip(chr(39))}: is required"
        case "union_tag_invalid":
            allowed = context["expected_tags"].replace("'", "").split(", ")
            tag = context["tag"]
            return f'{where}.shape: must be one of {", ".join(allowed)}, got "{tag}"{did_you_mean(tag, allowed)}'
        case "jkr":
            hint = ""
            if value == "rigid" and where == "indenter.E":
                hint = "; a rigid indenter is one without E and nu: leave both out"
            elif value == "rigid" and where.endswith(".E"):
                hint = (
                    "; an elastic lens on a rigid plate is the contact of a rigid lens on a half-space of the lens's "
                    'material: give that E and nu here and none in [indenter]; below layers base = "bonded" is rigid'
                )
            return f"{where}: {item['msg']}{hint}" if where else item["msg"]
        case "greater_than_equal" | "less_than_equal":
            bound = f">= {context['ge']}" if "ge" in context else f"<= {context['le']}"
            return f"{where}: must be {bound}, got {shown(value)}"
    wanted = next((f"must be {words}" for kinds, words in KINDS.items() if item["type"] in kinds), item["msg"])
    return f"{where}: {wanted}, got {shown(value)}"


def _path(loc: tuple[Any, ...], tree: dict[str, Any]) -> str:
    """``("specimen", "layers", 1, "E")`` -> ``specimen.layers[1].E``, as the keys stand in the file's ``tree``."""
    path, here = "", tree
    for part in loc:
        if isinstance(part, int):
            if not isinstance(here, list):
                continue  # a single value that stands for a list of one
            path += f"[{part}]"
            here = here[part] if part < len(here) else None
        elif part.startswith("<") or (part in SHAPES and isinstance(here, dict) and here.get("shape") == part):
            continue  # the tag of a material, a law or a shape, not a key
        else:
            path += f".{part}" if path else str(part)
            here = here.get(part) if isinstance(here, dict) else None  # type: ignore[assignment]
    return path


def _allowed(loc: tuple[Any, ...], keys_at: KeysAt) -> list[str]:
    """The keys that the table around an unknown key at ``loc`` may have."""
    return keys_at(tuple(part for part in loc[:-1] if not isinstance(part, int)))


def shown(value: Any) -> str:
    """A value as the user would recognise it, on one line and not too long."""
    if isinstance(value, str):
        text = '"' + value.replace("\n", "\\n") + '"'
    elif isinstance(value, bool):
        text = str(value).lower()
    else:
        text = "a table" if isinstance(value, dict) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."


# --------------------------------------------------------------------------------------------------
# Cases from problems made in Python: the inverse of the tables' ``build``.


def case_of(problem: Problem) -> Case:
    """A case of ``problem``, with defaults for all else; InputError where no case can say it."""
    if isinstance(problem.indenter.material, Coated):
        layers = [_layer(layer) for layer in problem.indenter.material.layers]
        indenter = _material(problem.indenter.material.core) | {"layers": layers}
    else:
        indenter = _material(problem.indenter.material)
    loading = problem.loading
    if loading.spacing != "given":
        to: dict[str, Any] = {loading.to: loading.maximum, "points": loading.points, "spacing": loading.spacing}
    else:
        to = {loading.to: loading.values} if len(loading.values) > 1 else {loading.to: loading.maximum, "points": 1}
    tree: dict[str, Any] = {"layers": [_layer(layer) for layer in problem.specimen.layers]}
    if isinstance(problem.specimen.base, HalfSpace):
        tree["half_space"] = _material(problem.specimen.base.material)
    else:
        tree["base"] = "bonded" if problem.specimen.base.bonded else "frictionless"
    if problem.specimen.radius is not None:
        tree |= {"radius": problem.specimen.radius, "side": problem.specimen.side}
    if problem.specimen.surface_tension:
        tree["surface_tension"] = problem.specimen.surface_tension
    if problem.specimen.relaxation is not None:
        tree["relaxation"] = RELAXATIONS.keys_in_file(problem.specimen.relaxation)
    tree = {
        "indenter": problem.indenter.keys | indenter,
        "specimen": tree | ({"surface": "sticking"} if problem.sticks else {}),
        "loading": to,
    }
    return Case(model_of(tree, "problem"), "problem")


def _material(material: Material | None) -> dict[str, Any]:
    if isinstance(material, Graded):
        return {"E": LAWS.keys_in_file(material.law), "nu": material.nu}
    if isinstance(material, GradedTransverselyIsotropic):
        return {key: LAWS.keys_in_file(one) if isinstance(one, Law) else one for key, one in vars(material).items()}
    return {} if material is None else dict(vars(material))


def _layer(layer: Layer) -> dict[str, Any]:
    return _material(layer.material) | {"thickness": layer.thickness, "name": layer.name}
