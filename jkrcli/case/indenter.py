"""The indenter table of a case file: one model per registered shape, made from its keys."""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_origin

from pydantic import Field, ValidationInfo, model_validator

from ..base import InputError, read_bytes
from ..bodies import SHAPES, Elastic, Indenter
from .fields import BuiltTable, Modulus, Poisson, findings, table_of, wrong

MOST_BYTES = 4 << 20  # choice: of a profile's file, a hundred thousand points are read in a second


class IndenterTable(BuiltTable):
    """Keys that every shape has: its name, E and nu of an elastic indenter (left out: rigid).

    A shape by lists may be given as a CSV ``file`` with a column in m for each, ``r_m`` for the key ``r``.
    """

    E: Modulus | None = None
    nu: Poisson | None = None
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
        return data | read_columns(folder / name, [f"{key}_m" for key in lists])

    @model_validator(mode="after")
    def _buildable(self) -> Self:
        if (self.E is None) != (self.nu is None):
            raise wrong("an elastic indenter needs both E and nu (leave both out for a rigid one)")
        with findings():
            self.build()
        return self

    def build(self) -> Indenter:
        """The indenter of the table."""
        indenter: Indenter = self.built(None if self.E is None or self.nu is None else Elastic(self.E, self.nu))
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
    """The columns ``wanted`` [m] of a CSV file with one header line that names them in any order, by key."""
    try:
        lines = read_bytes(path, "profile file", MOST_BYTES).decode("utf-8-sig").splitlines()
    except InputError as error:
        raise wrong(str(error)) from None
    except UnicodeDecodeError:
        raise wrong(f"{path}: profile file is not a text file") from None
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    if not set(wanted) <= set(names):
        header = " and ".join(wanted)
        raise wrong(f'{path}: line 1 must be a header with {header}, got "{(lines or [""])[0][:40]}"')
    rows = [_row(path, number, line, names) for number, line in enumerate(lines[1:], start=2) if line.strip()]
    return {name.removesuffix("_m"): tuple(row[name] for row in rows) for name in wanted}


def _row(path: Path, number: int, line: str, names: list[str]) -> dict[str, float]:
    try:
        cells = dict(zip(names, (float(cell) for cell in line.split(",")), strict=True))
    except ValueError:
        cells = {}
    if not cells or not all(math.isfinite(cell) for cell in cells.values()):
        raise wrong(f'{path}: line {number} must hold {len(names)} finite numbers, got "{line[:40]}"')
    return cells
