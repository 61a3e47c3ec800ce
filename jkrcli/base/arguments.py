"""What a user gives to functions and to the fields of dataclasses in Python, read by their annotations.

Quantities are numbers [SI] or text with a unit within their range (``units.Ranged``), choices are of a ``Literal`` or
the names of a registry (``OneOf``), lists are lists, tuples, arrays or series, and one value stands for a list of one;
everything else must be of the class that is named. What is wrong is an InputError that names parameter, value and what
is allowed.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import math
import os
import re
import types
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, fields
from functools import cache, partial
from pathlib import Path
from typing import (
    Annotated,
    Any,
    ClassVar,
    Literal,
    ParamSpec,
    TypeAlias,
    TypeVar,
    Union,
    cast,
    get_args,
    get_origin,
    get_type_hints,
)

from .errors import InputError, JkrError, did_you_mean
from .units import KindError, Ranged, is_number, plain, shortly
from .wings import absent

Read: TypeAlias = Callable[[Any], Any]  # what is meant by a value; ValueError with a full sentence where it is wrong
Words = ParamSpec("Words")
Answer = TypeVar("Answer")
MANY = 30  # choice: entries of a list, from which on its numbers are looked at together
LISTS = (tuple, list, frozenset, Sequence, Iterable, Collection)


@dataclass(frozen=True, eq=False)
class OneOf:
    """Annotation of a name among ``names``, which are looked up when it is read, or of ``more``; ``kind``: the word by
    which one of a wing that is not there is refused."""

    names: Iterable[str]
    more: tuple[str, ...] = ()
    kind: str = ""


@dataclass(frozen=True, eq=False)
class PerName:
    """Annotation of a mapping whose values are of other ``kinds`` by their names."""

    kinds: Mapping[str, Any]


@cache
def reader(kind: Any) -> Read:
    """What reads a value of the annotated ``kind``."""
    origin, parts = get_origin(kind), get_args(kind)
    if kind is Any:
        return lambda value: value
    if origin is Annotated:
        notes = [note for note in kind.__metadata__ if isinstance(note, Ranged | OneOf | PerName)]
        if not notes:
            return reader(parts[0])
        note = notes[-1]
        if isinstance(note, OneOf):
            return partial(_choice, (*note.more, *note.names), kind=note.kind)
        if isinstance(note, PerName):
            return partial(_per_name, note)
        return partial(_whole, note) if parts[0] is int else note.read
    if origin is Literal:
        return partial(_choice, parts)
    if origin in (Union, types.UnionType):
        kinds = [part for part in parts if part not in (type(None), Any)]  # beside others, Any is for type checkers
        return partial(_either, tuple(map(reader, kinds)), type(None) in parts)
    if origin in LISTS:
        several = frozenset if origin is frozenset else tuple
        if origin is tuple and parts[-1] is not Ellipsis:
            return partial(_several, several, tuple(map(reader, parts)), len(parts))
        return partial(_several, several, (reader(parts[0]),), 0)
    if origin is Mapping:
        return partial(_mapping, *map(reader, parts))
    simple: dict[Any, Read] = {
        bool: lambda value: _instance(bool, "true or false", plain(value)),
        int: partial(_whole, Ranged("number")),
        float: Ranged("number").read,
        str: _text,
        Path: lambda value: value if isinstance(value, Path) else Path(_instance((str, os.PathLike), "a path", value)),
    }
    if kind in simple:
        return simple[kind]
    return partial(_instance, kind, f"a {kind.__name__}") if isinstance(kind, type) else lambda value: value


def _choice(allowed: Sequence[Any], value: Any, kind: str = "") -> Any:
    value, words = plain(value), ", ".join(map(str, allowed))
    if isinstance(value, str | int) and not isinstance(value, bool) and value in allowed:
        return value
    if lacking := absent(f"{kind} {value}"):
        raise ValueError(f'"{value}" {lacking}')
    raise (
        KindError(f"one of {words}", value)
        if not isinstance(value, str)
        else ValueError(f'must be one of {words}, got "{value}"{did_you_mean(value, allowed)}')
    )


def _either(readers: Sequence[Read], optional: bool, value: Any) -> Any:
    if value is None and optional:
        return None
    errors = list[ValueError]()
    for by in readers:
        try:
            return by(value)
        except ValueError as error:
            errors.append(error)
    for found in errors:
        if not isinstance(found, KindError):  # it was of this kind
            raise found
    *first, last = dict.fromkeys(found.wanted for found in errors if isinstance(found, KindError))
    raise KindError(f"{', '.join(first)} or {last}" if first else last, value)


def _several(made: Callable[[Iterable[Any]], Any], readers: Sequence[Read], count: int, value: Any) -> Any:
    alone = not isinstance(value, Iterable) or isinstance(value, str | bytes)
    keyed = hasattr(value, "keys") and not hasattr(value, "dtype")  # a series of pandas has keys, too
    if keyed or (isinstance(value, Set) and made is tuple):
        raise KindError("a list", value)
    if len(getattr(value, "shape", ())) > 1:
        raise ValueError(f"must be one-dimensional, got shape {value.shape}")
    items = [value] if alone else list(value)
    if count and len(items) != count:
        raise KindError(f"{count} values", value)
    many = len(items) >= MANY and not count and all(type(item) is float and math.isfinite(item) for item in items)
    with contextlib.suppress(ValueError):  # as they are where the least and the largest are within the range
        if many and [readers[0](end) for end in (min(items), max(items))] == [min(items), max(items)]:
            return made(items)
    taken = []
    for i, item in enumerate(items):
        try:
            taken.append(readers[i if count else 0](item))
        except ValueError as error:
            if alone:
                raise
            raise ValueError(f"entry {i + 1} {error}") from None
    return made(taken)


def _per_name(note: PerName, value: Any) -> dict[str, Any]:
    pairs = _mapping(partial(_choice, tuple(note.kinds)), lambda item: item, value)
    return {name: _mapping(_text, reader(note.kinds[name]), {name: item})[name] for name, item in pairs.items()}


def _mapping(key: Read, item: Read, value: Any) -> dict[Any, Any]:
    if not (hasattr(value, "keys") and hasattr(value, "__getitem__")):
        raise KindError("a mapping, {name: value}", value)
    taken = {}
    for name in value.keys():  # noqa: SIM118 - of a series, too
        try:
            taken[key(name)] = item(value[name])
        except ValueError as error:
            raise ValueError(f"{shortly(name)} {error}") from None
    return taken


def _whole(ranged: Ranged, value: Any) -> int:
    number = plain(value)
    if not is_number(number) or number != number // 1:
        raise KindError("a whole number", number)
    if number not in ranged:
        raise ValueError(f"must be {ranged.rule}, got {number}")
    return int(number)


def _instance(kind: type | tuple[type, ...], wanted: str, value: Any) -> Any:
    if not isinstance(value, kind) or isinstance(value, type):  # a class has the methods of a protocol, too
        raise KindError(wanted, value)
    return value


_text: Read = partial(_instance, str, "a text")


# --------------------------------------------------------------------------------------------------
# Fields of dataclasses, parameters of functions, and options that are fields.


@cache
def ranges_of(kind: Any) -> dict[str, Ranged]:
    """The ranges of the fields of ``kind`` that are one number, or one or None."""
    ranges: dict[str, Ranged] = {}
    for name, annotation in get_type_hints(kind, include_extras=True).items():
        for part in get_args(annotation) if get_origin(annotation) is Union else (annotation,):
            for note in getattr(part, "__metadata__", ()):
                ranges |= {name: note} if isinstance(note, Ranged) else {}
    return ranges


@cache
def _fields(kind: Hashable) -> tuple[tuple[str, Read], ...]:
    hints = get_type_hints(kind, include_extras=True)
    return tuple((item.name, reader(hints[item.name])) for item in fields(cast(Any, kind)) if item.init)


def read_fields(thing: Any, where: str = "", sought: bool = False, **kinds: Any) -> None:
    """Read the fields of the frozen dataclass ``thing`` in place, some as of other ``kinds`` than annotated; InputError
    that names one, after ``where``. ``sought``: a fit makes it too, with numbers far from matter within their range."""
    for name, by in _fields(cast(Hashable, type(thing))):
        value = getattr(thing, name)
        if (
            sought
            and type(value) is float
            and math.isfinite(value)
            and value in ranges_of(cast(Hashable, type(thing)))[name]
        ):
            continue
        taken = read(f"{where}{where and '.'}{name}", reader(kinds[name]) if name in kinds else by, value)
        if taken is not value:
            object.__setattr__(thing, name, taken)


class Checked:
    """Base of the frozen dataclasses whose fields are read by their annotations, messages beginning with ``where``."""

    where: ClassVar[str] = ""

    def __post_init__(self) -> None:
        read_fields(self, self.where)


def read(name: str, by: Read, value: Any) -> Any:
    """What is meant by the ``value`` of the parameter ``name``; InputError that names both."""
    try:
        return by(value)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None


# Options in messages that the command line shares, but not of its commands, and what arguments in Python are called.
OPTION = re.compile(
    r"(?:jkr \w[\w-]*|make \w+|\b(?:import|export|fit|show)) --[\w-]+"
    r"|(?<![^\s(])--([A-Za-z][\w-]*)(?: ([\w:]+)=([^\s;,)]+))?"
)
ARGUMENTS = {
    "column": "columns", "unit": "units", "factor": "factors", "tip-radius": "tip_radii", "range": "length",
    "limit-memory": "limits.memory", "limit-time": "limits.hours",
}  # fmt: skip


def as_arguments(message: str) -> str:
    """A ``message`` with options of the command line as arguments: ``--unit P=nN`` as ``units={"P": "nN"}``."""

    def argument(option: re.Match[str]) -> str:
        if option[1] is None:
            return option[0]
        name = ARGUMENTS.get(option[1], option[1].replace("-", "_"))
        return name if option[2] is None else f'{name}={{"{option[2]}": "{option[3]}"}}'

    return OPTION.sub(argument, message)


def checked(function: Callable[Words, Answer]) -> Callable[Words, Answer]:
    """Decorator: the arguments of a public function are read by its annotations; InputError names the wrong one, and
    other errors name arguments where the command line has options."""
    signature = inspect.signature(function)
    open_ended = any(item.kind is item.VAR_KEYWORD for item in signature.parameters.values())

    @functools.wraps(function)
    def called(*values: Words.args, **named: Words.kwargs) -> Answer:
        if not open_ended:
            check_names(function.__name__, named, signature.parameters)
        try:
            bound = signature.bind(*values, **named)
        except TypeError as error:
            raise InputError(f"{function.__name__}: {error}") from None
        readers = _parameters(function)
        for name, value in bound.arguments.items():
            if name in readers:
                bound.arguments[name] = read(name, readers[name], value)
        try:
            return function(*bound.args, **bound.kwargs)
        except JkrError as error:
            error.args = tuple(as_arguments(str(part)) for part in error.args)
            if isinstance(error, InputError):
                error.lines = tuple(map(as_arguments, error.lines))
            raise

    return called


@cache
def _parameters(function: Any) -> dict[str, Read]:
    called: Any = types.SimpleNamespace(__annotations__={**function.__annotations__})
    called.__annotations__.pop("return", None)  # which may name what is imported where it is used
    hints = get_type_hints(called, inspect.unwrap(function).__globals__, include_extras=True)
    return {name: reader(kind) for name, kind in hints.items()}


def check_names(where: str, given: Iterable[str], allowed: Iterable[str]) -> None:
    """InputError where one of the names of parameters that were ``given`` is none of those ``allowed``."""
    names = list(allowed)
    for name in given:
        if name not in names:
            raise InputError(f'{where}: has no parameter "{name}"{did_you_mean(name, names)} ({", ".join(names)})')


def exactly_one(where: str, **given: Any) -> None:
    """InputError where not exactly one of these was ``given``; None: it was not."""
    if sum(value is not None for value in given.values()) != 1:
        raise InputError(f"{where}: give exactly one of {' and '.join(given)}")
