"""What a measured file holds, in words and as JSON: reading, segments, base lines, touch, jumps, adhesion, flags."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..base import InputError, Unknown, show
from ..beside.reach import Rough, rough
from ..bodies import Indenter
from ..data import ARBITRARY, Direction, ForceCurve, examine, measured
from .result import SHOWN, Figure, Result
from .tables import quantities

NO_BASE_LINE = Unknown("there is no base line")


@dataclass(frozen=True, eq=False)
class Look(Result):
    """What a measured file holds: its curves taken apart, and a line on each that is ``unusable``; ``tip``: of which a
    rough modulus is computed."""

    path: Path
    records: Sequence[ForceCurve]
    unusable: Sequence[str]
    tip: Indenter | None = None

    @classmethod
    def at(cls, path: Path, reading: measured.Reading, tip: Indenter | None = None) -> Look:
        """What the file at ``path`` holds, read by ``reading``; where spring constant or sensitivity are missing, 1
        stands in for them."""
        records: list[ForceCurve] = []
        unusable: list[str] = []
        try:
            for curve in measured.each(path, replace(reading, incomplete=True)):
                try:
                    if isinstance(curve, InputError):
                        raise curve
                    records.append(examine(curve))
                except InputError as error:
                    unusable += error.lines
        except InputError as error:
            unusable += error.lines
        return cls(path, records, unusable, tip)

    def summary(self) -> dict[str, Any]:
        return {
            "file": str(self.path),
            "curves": [as_dict(record) | self._rough(record) for record in self.records],
            "unusable": list(self.unusable),
        }

    def words(self) -> list[str]:
        lines = [line for record in self.records[:SHOWN] for line in words(record, self.tip)]
        if (count := len(self.records)) > 1:
            flagged = sum(bool(record.flags) for record in self.records)
            head = [f"{count} curves, {flagged} of them with remarks: {self.path}"]
            lines = [*head, *(f"  {words(record)[0]}" for record in self.records[:SHOWN]), *lines]
        return lines + ([f"  ... and {count - SHOWN} more curves (--json tells all)"] if count > SHOWN else [])

    def _rough(self, record: ForceCurve) -> dict[str, Any]:
        """The rough numbers of a record as plain values, where there is a tip."""
        if self.tip is None:
            return {}
        glance = at_a_glance(record, self.tip)
        if isinstance(glance, Unknown):
            return _known("rough", glance)
        return {"rough": quantities(glance, "E_star a") | _known("w_J_per_m2", glance.w)}

    @property
    def warnings(self) -> Sequence[str]:
        return self.unusable

    def figure(self) -> Figure:
        from .plots.segments import record_figure

        return record_figure(self.records)


def as_dict(record: ForceCurve) -> dict[str, Any]:
    """One curve as plain values, SI; a number that is not known is null, with its reason under ``..._unknown``."""
    curve = record.curve
    return {
        "curve": curve.name,
        "rows": len(curve),
        "columns": list(curve.measured),
        "read": list(curve.flags),
        "rows_of_no_segment": record.rest,
        "segments": [{"kind": s.kind, "first_row": s.first + 1, "last_row": s.last + 1} for s in record.segments],
        **{item.segment.kind: _direction(item) for item in record.directions},
        "flags": dict(record.flags),
    }


def _direction(item: Direction) -> dict[str, Any]:
    touch, adhesion = (item.touch, item.adhesion) if item.based else (NO_BASE_LINE, NO_BASE_LINE)
    return {
        "rows": len(item.segment),
        **_known("touch_m", touch),
        "touch_err_m": None if isinstance(touch, Unknown) else item.touch_err,
        "base_line": quantities(item.base, "offset tilt at rows noise waviness") if item.based else None,
        **_known("largest_load_N", item.largest if item.based else NO_BASE_LINE),
        **_known("adhesion_force_N", adhesion),
        "adhesion_at_m": None if isinstance(adhesion, Unknown) else item.adhesion_at,
        "jumps": [{"row": jump.row + 1} | quantities(jump, "position step") for jump in item.jumps],
    }


def _known(name: str, value: float | Unknown) -> dict[str, Any]:
    return {name: None, f"{name}_unknown": value.reason} if isinstance(value, Unknown) else {name: value}


def at_a_glance(record: ForceCurve, tip: Indenter) -> Rough | Unknown:
    """What the formulas of a half-space make of the direction that is nearest to no adhesion, the approach."""
    if any(ARBITRARY in flag for flag in record.curve.flags):
        return Unknown("loads are in arbitrary units")
    item = record.direction("approach") or record.direction("retract")
    if item is None or not item.based or isinstance(item.touch, Unknown):
        return Unknown("no base line and first touch")
    back = record.direction("retract")
    adhesion = back.adhesion if back is not None and back.based else Unknown("no retraction with a base line")
    depth = item.depth - (0.0 if record.curve.stiffness is None else item.largest / record.curve.stiffness)
    return rough(tip, item.largest, depth, adhesion)


def _glance(record: ForceCurve, tip: Indenter) -> str:
    glance = at_a_glance(record, tip)
    if isinstance(glance, Unknown):
        return f"  no rough modulus: {glance.reason}"
    w = "" if isinstance(glance.w, Unknown) else f", w = {show(glance.w, 'work', 2)} (adhesion force)"
    E_star, a = show(glance.E_star, "modulus", 2), show(glance.a, "length", 2)
    return f"  rough: E* = {E_star} (half-space without adhesion, largest load, a = {a}){w}"


def words(record: ForceCurve, tip: Indenter | None = None) -> list[str]:
    """Lines for a reader: what the record is, then a line per direction and per flag; a rough modulus by a ``tip``."""
    curve = record.curve
    columns = ", ".join(map(measured.text.NAMES.meaning, curve.measured))
    parts = ", ".join(f"{segment.kind} {len(segment)}" for segment in record.segments)
    parts += f", {record.rest} of neither" if record.rest else ""
    return [
        f"{_verdict(record)}: {curve.where}",
        f"  {len(curve)} rows of {columns}; {parts}",
        *([] if tip is None else [_glance(record, tip)]),
        *(f"  {name}: {sentence}" for name, sentence in record.flags.items()),
        *(f"  {item.segment.kind:8}  {line}" for item in record.directions for line in _direction_words(item)),
        *(f"  {flag}" for flag in curve.flags),
    ]


def _verdict(record: ForceCurve) -> str:
    """The adhesion force and the largest load, where the base line gives them."""
    forces = {}
    for item in record.directions if all(item.based for item in record.directions) else ():
        if item.segment.kind != "approach" and not isinstance(item.adhesion, Unknown):
            forces["adhesion force"] = item.adhesion
        forces["largest load"] = max(item.largest, forces.get("largest load", item.largest))
    words = [f"{name} {show(forces[name], 'load', 3)}" for name in ("adhesion force", "largest load") if name in forces]
    return ", ".join(words) or "no force without a base line"


def _direction_words(item: Direction) -> list[str]:
    approach = item.segment.kind == "approach"
    base = item.base
    line = (
        f"base line of {base.rows} rows: noise {show(base.noise, 'load', 3)}, "
        f"tilt {show(base.tilt, 'stiffness', 3)}, waviness {show(base.waviness, 'load', 3)}"
    )
    if isinstance(item.touch, Unknown):
        return [item.touch.reason, line]
    if not item.based:
        where = "begins and the largest load" if approach else "ends and the adhesion force"
        return [f"no straight base line: where contact {where} are unknown"]
    touch = f"{show(item.touch, 'length')} ± {show(item.touch_err, 'length', 3)}"
    tension = (
        f"unknown, {item.adhesion.reason}"
        if isinstance(item.adhesion, Unknown)
        else f"{show(item.adhesion, 'load', 3)} at {show(item.adhesion_at, 'length')}"
    )
    count = len(item.jumps)
    if approach:
        jump = f"jump into contact by {show(-item.jumps[0].step, 'load', 3)}" if count else "no jump into contact"
        return [f"contact from {touch} on, up to {show(item.largest, 'load', 3)}, {jump}", line]
    places = ", ".join(show(jump.position, "length") for jump in item.jumps)
    jumps = {0: "without a jump", 1: f"by one jump at {places}"}.get(count, f"by {count} jumps at {places}")
    return [f"adhesion force {tension}; free from {touch} on, {jumps}", line]
