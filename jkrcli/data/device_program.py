"""What a device does over time, from a table of two columns."""

from __future__ import annotations

from pathlib import Path

from ..base import Array, InputError
from ..tables.text_table import read_table
from ..tables.titles import split_name, unit_power


def read_program(path: Path, dimension: str) -> tuple[Array, Array]:
    """Times [s] and positions [m], or loads [N] where ``dimension`` is "load", of the table at ``path``.

    Its first column is the time, its second what the device holds; names may carry units ("t_ms,x_um"), else SI.
    """
    table = read_table(path, least=2)
    if table.values.shape[1] != 2:
        raise InputError(f"{path}: a program has two columns, time and position, got {table.values.shape[1]}")
    columns = []
    for index, wanted in enumerate(("time", dimension)):
        unit = split_name(table.names[index])[1] if table.names else None
        power = (wanted, 0) if not unit else unit_power(unit)
        if power is None or power[0] != wanted:
            raise InputError(f'{path}: column {index + 1} is to be a {wanted}, got the unit "{unit}"')
        columns.append(table.values[:, index] * 10.0 ** power[1])
    return columns[0], columns[1]
