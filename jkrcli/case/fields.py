"""Building blocks of the case tables: types that read numbers with dimension and range, and the strict table itself."""

from __future__ import annotations

import contextlib
import functools
import operator
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, TypeVar, Union, get_args, get_origin

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    GetCoreSchemaHandler,
    Tag,
    ValidationError,
    create_model,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError
from pydantic_core.core_schema import no_info_before_validator_function

from ..base import InputError, Ranged, Registry, units

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
    own = [] if unknown else [InitErrorDetails(type=wrong(finding), input=data)]
    raise ValidationError.from_exception_data("table", [*own, *map(_again, items)])


def _again(item: Any) -> InitErrorDetails:
    """A finding of pydantic's in the form in which it takes findings."""
    kind = wrong(item["msg"]) if item["type"] == "jkr" else item["type"]
    return InitErrorDetails(type=kind, loc=item["loc"], input=item["input"], ctx=item.get("ctx", {}))


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


def quantity(dimension: str, **bounds: float) -> Any:
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
