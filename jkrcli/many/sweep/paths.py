"""Keys of a case file as paths, "specimen.layers[0].nu": written into its tables, read from its model."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...base import InputError
from ...case import CaseModel, model_of

KeyPath = tuple[str | int, ...]
Tables = dict[str, Any]
LAYER_COUNT = "specimen.layers.count"  # a key of sweeps alone: the first so many layers of the base case
_KEY = re.compile(r"[A-Za-z_]\w*(\[\d+\])?(\.[A-Za-z_]\w*(\[\d+\])?)*")
UNITS = {"m": "m", "Pa": "Pa", "N": "N", "J/m^2": "J_per_m2", "N/m": "N_per_m", "rad": "rad"}


def parse(key: str) -> KeyPath:
    """``"specimen.layers[0].nu"`` -> ``("specimen", "layers", 0, "nu")``."""
    if not _KEY.fullmatch(key):
        raise InputError(f'must be a key of a case such as "specimen.layers[0].nu", got "{key}"')
    return tuple(int(part) if part.isdigit() else part for part in re.findall(r"\w+", key))


def with_values(tables: Tables, values: Mapping[str, Any]) -> Tables:
    """A copy of a case's tables in which every key has its value."""
    changed = copy.deepcopy(tables)
    for key, value in values.items():
        if key != LAYER_COUNT:
            _assign(changed, key, copy.deepcopy(value))
    if LAYER_COUNT in values:
        _keep_layers(changed, values[LAYER_COUNT])
    return changed


def _assign(tables: Tables, key: str, value: Any) -> None:
    *parents, last = parse(key)
    here: Any = tables
    for i, part in enumerate([*parents, last]):
        is_list = isinstance(here, list | tuple)
        if isinstance(part, int) and not (is_list and part < len(here)):
            raise InputError(f"{key}: the base case has {len(here) if is_list else 0} entries there, numbered from 0")
        if isinstance(part, str) and not isinstance(here, dict):
            listed = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in parents[:i]).removeprefix(".")
            remedy = f"a list, its entries are {listed}[0], [1], ..." if is_list else "no table"
            raise InputError(f'{key}: has no "{part}": {listed} is {remedy}')
        if i == len(parents):
            here[part] = value
        else:
            here = here[part] if isinstance(part, int) else here.setdefault(part, {})


def _keep_layers(tables: Tables, count: Any) -> None:
    layers = tables.get("specimen", {}).get("layers", [])
    number = isinstance(count, int | float) and not isinstance(count, bool)
    if not (number and 0 <= count <= len(layers) and count == int(count)):
        raise InputError(f"{LAYER_COUNT}: must be a whole number from 0 to {len(layers)}, got {count}")
    tables["specimen"]["layers"] = layers[: int(count)]


def value_at(model: CaseModel, key: str) -> Any:
    """The value of ``key`` in SI; tables as plain dicts, a list of one number as the number."""
    if key == LAYER_COUNT:
        return len(model.specimen.layers)
    here: Any = model.model_dump(exclude_none=True)
    for part in parse(key):
        here = here[part]
    if isinstance(here, tuple) and len(here) == 1 and isinstance(here[0], float):
        return here[0]
    return here


def unit_of(tables: Tables, key: str, value: Any, folder: Path | None) -> str:
    """The SI unit of ``key`` for a column's name, "" for plain numbers and words: the one that the case accepts."""
    if key == LAYER_COUNT or isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    for unit, name in UNITS.items():
        try:
            model_of(with_values(tables, {key: f"{value!r} {unit}"}), "", folder)
        except InputError:
            continue
        return name
    return ""
