"""The indenter table of a case file, one model per shape."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationInfo, model_validator

from ..base.errors import InputError
from ..base.files import read_bytes
from ..bodies.indenters import Indenter, Paraboloid, PowerLaw, RoundedFlat, Sphere, TableProfile
from ..bodies.materials import Elastic
from .fields import AnyLength, Length, Modulus, Poisson, Table, as_tuple, quantity, wrong


class IndenterTable(Table):
    """Keys that every shape has: E and nu of an elastic indenter (left out: rigid)."""

    E: Modulus | None = None
    nu: Poisson | None = None

    @model_validator(mode="after")
    def _both(self) -> Self:
        if (self.E is None) != (self.nu is None):
            raise wrong("an elastic indenter needs both E and nu (leave both out for a rigid one)")
        return self

    def build(self) -> Indenter:
        raise AssertionError("each shape builds its own")

    @property
    def material(self) -> Elastic | None:
        return None if self.E is None or self.nu is None else Elastic(self.E, self.nu)


class SphereTable(IndenterTable):
    shape: Literal["sphere"]
    radius: Length

    def build(self) -> Indenter:
        return Sphere(self.radius, self.material)


class ParaboloidTable(IndenterTable):
    """``counter_radius``: radius of a spherical specimen (negative: a cavity), 1/R = 1/radius + 1/counter_radius."""

    shape: Literal["paraboloid"]
    radius: Length
    counter_radius: AnyLength | None = None

    @model_validator(mode="after")
    def _opens(self) -> Self:
        c = self.counter_radius
        if c is not None and (c == 0 or 1 / self.radius + 1 / c <= 0):
            raise wrong(f"counter_radius must be > 0, or < -radius for a cavity that the indenter fits, got {c:g} m")
        return self

    def build(self) -> Indenter:
        curvature = 1 / self.radius + (1 / self.counter_radius if self.counter_radius else 0.0)
        return Paraboloid(1 / curvature, self.material)


class PowerTable(IndenterTable):
    """f = coefficient r^exponent in SI (coefficient in m^(1 - exponent))."""

    shape: Literal["power"]
    coefficient: quantity("number", above=0)
    exponent: quantity("number", least=1, most=20)

    def build(self) -> Indenter:
        return PowerLaw(self.coefficient, self.exponent, self.material)


class ConeTable(IndenterTable):
    """``half_angle``: between the axis and the surface."""

    shape: Literal["cone"]
    half_angle: quantity("angle", above=0, below=math.pi / 2)

    def build(self) -> Indenter:
        return PowerLaw(1 / math.tan(self.half_angle), 1.0, self.material)


class FlatTable(IndenterTable):
    """A flat end of ``flat_radius`` with a parabolic edge of ``edge_radius``."""

    shape: Literal["flat"]
    flat_radius: Length
    edge_radius: Length

    def build(self) -> Indenter:
        return RoundedFlat(self.flat_radius, self.edge_radius, self.material)


class ProfileTable(IndenterTable):
    """A profile by points: lists ``r`` and ``f``, or a CSV ``file`` with columns r_m, f_m (read into the lists)."""

    shape: Literal["table"]
    r: tuple[AnyLength, ...] = ()
    f: tuple[AnyLength, ...] = ()

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, dict):
            return data
        data = {key: as_tuple(v) for key, v in data.items()}
        name = data.pop("file", None)
        if name is None:
            return data
        if not isinstance(name, str) or "r" in data or "f" in data:
            raise wrong("give either file or the lists r and f")
        folder = (info.context or {}).get("folder") or Path()
        data["r"], data["f"] = read_profile(folder / name)
        return data

    @model_validator(mode="after")
    def _convex(self) -> Self:
        try:
            self.build()
        except InputError as error:
            raise wrong(str(error)) from None
        return self

    def build(self) -> Indenter:
        return TableProfile(self.r, self.f, self.material)


def read_profile(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The columns r_m and f_m [m] of a CSV file with one header line that names them, in any order."""
    try:
        lines = read_bytes(path, "profile file").decode("utf-8-sig").splitlines()
    except InputError as error:
        raise wrong(str(error)) from None
    except UnicodeDecodeError:
        raise wrong(f"{path}: profile file is not a text file") from None
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    if not {"r_m", "f_m"} <= set(names):
        raise wrong(f'{path}: line 1 must be a header with r_m and f_m, got "{(lines or [""])[0][:40]}"')
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        if line.strip():
            rows.append(_row(path, number, line, names))
    return tuple(r for r, _ in rows), tuple(f for _, f in rows)


def _row(path: Path, number: int, line: str, names: list[str]) -> tuple[float, float]:
    try:
        cells = dict(zip(names, (float(cell) for cell in line.split(",")), strict=True))
    except ValueError:
        cells = {}
    if not cells or not all(math.isfinite(cell) for cell in cells.values()):
        raise wrong(f'{path}: line {number} must hold {len(names)} finite numbers, got "{line[:40]}"')
    return cells["r_m"], cells["f_m"]


AnyIndenter = Annotated[
    SphereTable | ParaboloidTable | PowerTable | ConeTable | FlatTable | ProfileTable, Field(discriminator="shape")
]
SHAPES = ("sphere", "paraboloid", "power", "cone", "flat", "table")
