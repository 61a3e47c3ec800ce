"""The keys of a case file as tables, from the models that read it: what a key holds, and its default."""

from __future__ import annotations

import inspect
import re
import types
from collections.abc import Iterable, Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BeforeValidator

from jkrcli.base.units import DIMENSIONS, Ranged
from jkrcli.bodies.indenters import SHAPES
from jkrcli.bodies.problem import LAWS, RELAXATIONS
from jkrcli.case.models import (
    AdhesionTable,
    CapillaryTable,
    CoatingTable,
    LawTable,
    LayerTable,
    LoadingTable,
    Read,
    SpecimenTable,
    Table,
    TransverseLayerTable,
    as_several,
    places,
)
from jkrcli.methods.protocol import METHODS

PLAIN = {str: "text", bool: "true or false", int: "a whole number", float: "a number", type(None): ""}


def page() -> str:
    """The whole page but its head."""
    return "\n\n".join(_sections())


def _sections() -> Iterator[str]:
    methods = ", ".join(f"`{name}`" for name in METHODS)
    yield "## At the top"
    yield _table([("title", "text", '`""`'), ("method", f"`auto` or one of {methods}", "`auto`")])
    yield "## `[indenter]`"
    yield _table([
        ("shape", f"one of {', '.join(f'`{name}`' for name in SHAPES)}", "required"),
        ("E", "a modulus (Pa) > 0: an elastic indenter", "rigid"), ("nu", "its Poisson's ratio", "rigid"),
    ])  # fmt: skip
    for name, builder in SHAPES.items():
        yield f'### `shape = "{name}"`'
        yield _prose(builder)
        yield _registered(SHAPES, name)
    note = "A homogeneous layer on an elastic indenter, isotropic or by five constants; the first is outermost."
    yield from _model("[[indenter.layers]]", CoatingTable, note=note)
    yield from _model("[specimen]", SpecimenTable, leave=("layers", "half_space", "relaxation"))
    for name, builder in RELAXATIONS.items():
        yield f'### `relaxation = {{ law = "{name}", ... }}`'
        yield _prose(builder)
        yield _registered(RELAXATIONS, name)
    yield from _model("[[specimen.layers]]", LayerTable, note="An isotropic layer; the first is at the contact.")
    for name, builder in LAWS.items():
        yield f'### `E = {{ law = "{name}", ... }}`'
        yield _prose(builder)
        yield _registered(LAWS, name)
    yield from _model("A transversely isotropic layer", TransverseLayerTable, level="###")
    yield "## `[specimen.half_space]`"
    yield (
        "An elastic half-space below the layers, or alone: `E` and `nu`, or the five constants of a transversely "
        "isotropic material, numbers all."
    )
    yield from _model("[loading]", LoadingTable)
    yield from _model("[adhesion]", AdhesionTable)
    yield from _model("`capillary = { ... }`", CapillaryTable, level="###")
    yield from _methods()


def _methods() -> Iterator[str]:
    for method in METHODS.values():
        if method.options is None:
            continue
        for table in dict.fromkeys(place.table for place in places(method).values()):
            yield f"## `[{table}]`"
            yield f"Of the method `{method.name}`."
            yield _fields(
                (place.key, place.annotation, place.default)
                for place in places(method).values()
                if place.table == table
            )
            if table == (method.table or method.name):
                yield _prose(method.options)


def _model(
    title: str, model: type[Table], leave: tuple[str, ...] = (), note: str = "", level: str = "##"
) -> Iterator[str]:
    yield f"{level} `{title}`" if title.startswith("[") else f"{level} {title}"
    yield note or _prose(model)
    fields = model.model_fields.items()
    yield _fields(
        (name, Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation,
         ... if field.is_required() else field.default)
        for name, field in fields if name not in leave
    )  # fmt: skip


def _registered(registry: Any, name: str) -> str:
    found = registry.parameters(name).items()
    return _fields((key, item.annotation, item.default) for key, item in found if key != registry.inherited)


def _fields(fields: Iterable[tuple[str, Any, Any]]) -> str:
    return _table([(key, holds(annotation), _default(default)) for key, annotation, default in fields])


def _table(rows: list[tuple[str, str, str]]) -> str:
    lines = [f"| `{key}` | {what} | {default} |" for key, what, default in rows]
    return "\n".join(["| key | holds | default |", "|---|---|---|", *lines])


def _default(value: Any) -> str:
    if value is ...:
        return "required"
    if value is None or value == ():
        return "left out"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"`{list(value) if isinstance(value, tuple) else value}`"


def holds(annotation: Any) -> str:
    """What a file may hold where ``annotation`` is the type of a key, in words."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _annotated(parts[0], annotation.__metadata__)
    if origin is Literal:
        return " or ".join(f"`{word!r}`".replace("'", '"') for word in parts)
    if origin in (Union, types.UnionType):
        return " or ".join(dict.fromkeys(filter(None, map(holds, parts))))
    if origin is tuple:
        count = "" if parts[-1] is ... else f" of {len(parts)}"
        return f"a list{count}, each {holds(parts[0])}"
    if inspect.isclass(annotation) and issubclass(annotation, LawTable):
        return "a law over the depth"
    return PLAIN.get(annotation, "a table")


def _annotated(kind: Any, notes: Iterable[Any]) -> str:
    for note in notes:
        if isinstance(note, BeforeValidator) and note.func is as_several:
            return f"{holds(get_args(kind)[0])}, or a list of several"
        ranged = note.ranged if isinstance(note, Read) else note
        if isinstance(ranged, Ranged):
            return _ranged(ranged)
    bounds = " and ".join(
        f"{sign} {getattr(note, name)}"
        for note in notes
        for name, sign in (("ge", ">="), ("le", "<="))
        if getattr(note, name, None) is not None
    )
    return f"{holds(kind)} {bounds}".strip()


def _ranged(ranged: Ranged) -> str:
    words, unit, *_ = DIMENSIONS[ranged.dimension]
    return " ".join(filter(None, (words.replace("plain ", ""), unit and f"({unit})", ranged.rule)))


def _prose(thing: Any) -> str:
    """A docstring as markdown: lines that begin with the name of a key as a list."""
    text = (inspect.getdoc(thing) or "").replace("<", "\\<").replace("*", "\\*")
    return re.sub(r"^(?=``)", "\n- ", text, flags=re.MULTILINE).replace("``", "`")
