"""One measured curve, in SI, as recorded, and how it is to be read: columns, units, signs, offsets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np

from ..base.arguments import OneOf, PerName, read, read_fields
from ..base.errors import InputError
from ..base.numerics import Array, numbers_of
from ..base.units import AnyForce, AnyLength, Ranged, Sensitivity, Stiffness
from ..series.vocabulary import NO_UNIT, VOCABULARIES, factors_of
from ..tables import SEPARATORS

NAMES = VOCABULARIES["measured"]
QUANTITIES = ("a", "delta", "P", "t")
APPROACH, RETRACT = "approach", "retract"
LEAST_ROWS = 3  # theory: E* and w take two rows, the third shows how well they fit


@dataclass(frozen=True)
class Pixel:
    """Where in a map a curve was taken: ``column, row`` from 0 on, ``x, y`` [m] of the device in the plane, None where
    its file holds no positions."""

    column: int
    row: int
    x: float | None = None
    y: float | None = None


NOT_SUBTRACTED = "the deflection of the cantilever is not subtracted: give --stiffness"  # a flag of a curve
GAPS = " without a number left out"  # in a flag
# Others:
SUBTRACTED_TWICE = "the displacement has its deflection subtracted already: leave --stiffness out"
AS_DEPTH = "the displacement is taken as the depth of the tip: give --stiffness if it is that of the instrument"
ARBITRARY = "arbitrary units, give"  # in a flag
TURNED = ", sign changed"  # in a flag of a displacement: by name or load, or as told; --factor delta=-1 undoes it
OVERRULED = " as specified, the header of the file says "  # in a flag, between two stiffnesses


@dataclass(frozen=True, eq=False)
class Curve:
    """One measured curve: contact radius ``a`` [m], displacement ``delta`` [m], load ``P`` [N], time ``t`` [s].

    None stands where one was not measured. One-dimensional read-only arrays of equal length; rows are neither ordered
    nor, in ``delta`` and ``P``, of known zero: signs are those of the project (indentation and compression positive).
    ``segment``: a word per row ("approach", "retract" or another), None where unknown. ``name``: unique in its file;
    ``origin``: that file; ``flags``: sentences on how the rows were read. ``stiffness`` [N/m]: of the device whose
    deflection was subtracted from ``delta``; None: ``delta`` is as it was recorded. ``pixel``: of a map, if it is one;
    ``sample``: as its file names it.
    """

    name: str
    a: Array | None = None
    delta: Array | None = None
    P: Array | None = None
    t: Array | None = None
    segment: Array | None = None
    origin: Path | None = None
    flags: tuple[str, ...] = ()
    stiffness: float | None = None
    pixel: Pixel | None = None
    sample: str = ""

    def __post_init__(self) -> None:
        sizes = {}
        for name in (*self.measured, *(() if self.segment is None else ("segment",))):
            given = getattr(self, name)
            is_fixed = isinstance(given, np.ndarray) and given.flags.owndata and not given.flags.writeable
            if is_fixed or name == "segment":  # the columns of another curve are not copied
                array = (np.asarray if is_fixed else np.array)(given, dtype=str if name == "segment" else float)
            else:
                array = read(f"{self.where}: {name}", numbers_of, given)
            if name != "segment" and not np.isfinite(array).all():
                raise InputError(f"{self.where}: {name}[{int(np.argmin(np.isfinite(array)))}] is not finite")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
            sizes[name] = array.size
        if not self.measured or self.measured == ("t",):
            raise InputError(f"{self.where}: holds none of a, delta, P")
        if len(set(sizes.values())) != 1:
            raise InputError(f"{self.where}: all columns must have the same length, got {sizes}")

    def __len__(self) -> int:
        return len(getattr(self, self.measured[0]))

    @property
    def where(self) -> str:
        """File and name, for messages; a file of one curve gives it its name."""
        return self.name if self.origin is None else place(self.origin, self.name)

    @property
    def doubts(self) -> list[str]:
        """Of its flags those that stand against what is made of its numbers."""
        in_series = "E* is that of contact and instrument in series: "
        parts = AS_DEPTH, SUBTRACTED_TWICE, NOT_SUBTRACTED, OVERRULED, NO_UNIT, GAPS
        return [in_series * (flag == NOT_SUBTRACTED) + flag for flag in self.flags if any(one in flag for one in parts)]

    @property
    def likely(self) -> str:
        """Behind the reason why it cannot be used: what of its reading is likely the cause; empty where nothing is."""
        return "".join(f"; {flag}" for flag in self.flags if flag in (NOT_SUBTRACTED, SUBTRACTED_TWICE))

    @property
    def measured(self) -> tuple[str, ...]:
        """The names of the quantities that were measured, of a, delta, P, t."""
        return tuple(name for name in QUANTITIES if getattr(self, name) is not None)

    def column(self, name: str, purpose: str = "") -> Array:
        """A quantity that was measured; InputError, which may name the ``purpose``, where it was not."""
        values: Array | None = getattr(self, name)
        if values is None:
            raise InputError(f"{self.where}: holds no {name}{purpose} (it holds {', '.join(self.measured)})")
        return values

    @property
    def depth(self) -> Array:
        """The displacement [m], which was measured."""
        return self.column("delta")

    @property
    def load(self) -> Array:
        """The load [N], which was measured."""
        return self.column("P")

    @property
    def time(self) -> Array:
        """The times [s], which were measured."""
        return self.column("t")

    @property
    def device(self) -> Array:
        """Position of the device [m], its deflection added again; needs displacement and load."""
        return self.depth if self.stiffness is None else self.depth + self.load / self.stiffness

    def rows(self, chosen: Array) -> Curve:
        """The curve at ``chosen`` rows alone (a mask or numbers)."""
        columns = {name: getattr(self, name) for name in (*QUANTITIES, "segment")}
        taken: dict[str, Any] = {name: None if column is None else column[chosen] for name, column in columns.items()}
        return replace(self, **taken)

    def multiplied(self, factors: Mapping[str, float]) -> Curve:
        """The curve with its quantities multiplied; InputError names one that was not measured."""
        columns: dict[str, Any] = {key: self.column(key, " to multiply") * number for key, number in factors.items()}
        return replace(self, **columns) if columns else self

    def only(self, segment: str) -> Curve:
        """The rows of one segment; InputError names the segments there are, where this is none of them."""
        if self.segment is None:
            raise InputError(f'{self.where}: names no segments, cannot take "{segment}" alone')
        chosen = self.segment == segment
        if not chosen.any():
            raise InputError(
                f'{self.where}: has no rows of segment "{segment}" (segments: {", ".join(self.segments())})'
            )
        return self.rows(chosen)

    def segments(self) -> tuple[str, ...]:
        """The different words of ``segment``, in order of appearance."""
        return () if self.segment is None else tuple(dict.fromkeys(self.segment.tolist()))


# With the stiffness of its device [N/m]; of a curve that the reading leaves out its name alone, the rest not read.
AsRead: TypeAlias = tuple[Curve | InputError | str, float | None]


def place(origin: Path, name: str) -> str:
    """File and name of a curve, for messages; a file of one curve gives it its name."""
    return str(origin) if name == origin.stem else f'{origin}: curve "{name}"'


Row: TypeAlias = Annotated[int, Ranged("number", least=1)]


@dataclass(frozen=True)
class Reading:
    """State the conventions of a measurement; by default SI, indentation and compression positive.

    Parameters
    ----------
    columns : mapping, optional
        Column names or numbers (from 1) where the header does not say, by "a", "delta", "P", "t", "area" (projected
        contact area), "diameter" (of the contact), "segment", "curve".
    units : mapping, optional
        Units where the header has none or a wrong one: ``{"P": "nN"}``.
    factors : mapping, optional
        Multiply quantities, in addition to their units: ``{"P": 1000}``.
    flip : "delta", "P" or both, optional
        Columns whose sign is reversed: compression and indentation are positive in `jkr`.
    stiffness : float or str, optional
        Of the cantilever or machine [N/m]: P/stiffness is subtracted from piezo positions; of a microscope's file its
        spring constant, where the file lacks it. "rigid": nothing is subtracted.
    sensitivity : float or str, optional
        Deflection over volts [m/V] of a microscope, where its file lacks it.
    zero : mapping, optional
        Known contact point [m] and force offset [N], subtracted after the change of sign.
    contact : {"auto", "fitted", "as-is", "estimate"}, optional
        Contact point and force offset: "estimate" from the approach before contact, "as-is" those of the file,
        "fitted" by a fit.
    format : {"auto", "text", "afm"}, optional
        "afm": a microscope's; "auto": by the content and the ending of the name.
    separator, decimal : str, optional
        Between columns, a name such as "comma"; "." or ",". Default: detected.
    incomplete : bool, optional
        Read a microscope's file that lacks spring constant or sensitivity all the same, with 1 for each.
    rows : (int, int), optional
        First and last row of each curve, from 1.
    where : mapping, optional
        Only rows of the segment (key "segment"), the curve ("curve"), or the content of a column of a table, by its
        name or number.

    Raises
    ------
    InputError
        Names the field, the value and what is allowed.
    """

    columns: Annotated[Mapping[str, str], PerName(dict.fromkeys(NAMES.quantities, str | int))] = field(
        default_factory=dict
    )
    units: Mapping[str, str] = field(default_factory=dict)
    factors: Annotated[Mapping[str, float], PerName(dict.fromkeys(NAMES.numbers, float))] = field(default_factory=dict)
    flip: frozenset[Literal["delta", "P"]] = frozenset()
    stiffness: Stiffness | None = None
    sensitivity: Sensitivity | None = None
    zero: Annotated[Mapping[str, float], PerName({"delta": AnyLength, "P": AnyForce})] = field(default_factory=dict)
    contact: Literal["auto", "fitted", "as-is", "estimate"] = "auto"
    format: Literal["auto", "text", "afm"] = "auto"
    separator: Annotated[str, OneOf(SEPARATORS)] | None = None
    decimal: Literal[".", ","] | None = None
    incomplete: bool = False
    rows: tuple[Row, Row] | None = None
    where: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Take texts with units for numbers, "0.6 N/m"; InputError where one is no such number, or a word none of its
        field's."""
        read_fields(self)
        object.__setattr__(self, "columns", {key: str(name) for key, name in self.columns.items()})
        object.__setattr__(self, "factors", factors_of(self.factors))
        if self.rows is not None and self.rows[0] > self.rows[1]:
            raise InputError(
                f"rows: must be the first and the last row, counted from 1, as (100, 900), got {self.rows}"
            )

    def refuse_contact(self, verb: str) -> None:
        """InputError where the contact point is to be left or fitted by a ``verb`` that fits nothing."""
        if self.contact in ("as-is", "fitted"):
            raise InputError(
                f"{verb}: --contact {self.contact} has no effect: nothing is fitted here; --contact estimate finds "
                "contact point and force offset by the rows before contact"
            )

    def wants(self, name: str) -> bool:
        """Whether the curve of this name is read."""
        return self.where.get("curve") in (None, name)

    def check_known_columns(self, path: Path) -> None:
        """Refuse columns, their units and rows by them for a file whose format names them."""
        if others := self.where.keys() - {"segment", "curve"}:
            raise InputError(f'{path}: is a microscope\'s file, of which --where takes segment or curve, not '
                             f'"{min(others)}"')  # fmt: skip
        if self.columns or self.units:
            raise InputError(f"{path}: the columns of a microscope's file and their units are known: leave out "
                             "--column and --unit, or read it as text, --format text")  # fmt: skip
