"""The indenter table of a case file: one model per registered shape, made from its keys."""

from __future__ import annotations

import functools
import operator
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, Self, cast, get_origin

from pydantic import BeforeValidator, Field, ValidationInfo, model_validator

from ..base import InputError, read_bytes
from ..bodies import SHAPES, Coated, Elastic, Indenter, Solid
from ..tables.text_table import TextTable, read_table
from ..tables.titles import split_name, unit_power
from .fields import BuiltTable, Modulus, Poisson, as_tuple, findings, table_of, wrong
from .materials import AnyCoating

CALLED = {"r": ("r", "radius"), "f": ("f", "z", "height")}  # columns of a profile
MOST_BYTES = 4 << 20  # choice: of a profile's file, a hundred thousand points are read in a second


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
        indenter: Indenter = self.built(material)
        return indenter

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
    try:
        content = read_bytes(path, "profile file", MOST_BYTES)
        table = read_table(path, least=len(wanted), content=content)
        chosen = {name: _column(table, name) for name in wanted}
    except InputError as error:
        raise wrong("; ".join(error.lines)) from None
    return {name: tuple((scale * table.values[:, i]).tolist()) for name, (i, scale) in chosen.items()}


def _column(table: TextTable, name: str) -> tuple[int, float]:
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
