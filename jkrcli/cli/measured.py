"""The options by which verbs read measured curves: one set for all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from ..data import SEPARATORS, Reading
from ..data.measured.text import NAMES
from ..methods import Forecast, Limits
from . import options
from .verb import as_one


@dataclass(frozen=True)
class TableTuning:
    """What tables cost, and what verbs do with their rows."""

    per_row: float = 3e-6  # CPU seconds to read; tuned on tables of 1e5 and 1e6 rows, by `make guards`
    mib_per_row: float = 7e-4  # of memory; tuned on the same, by `make guards`
    cycle_per_row: float = 0.012  # CPU seconds of `jkr cycle --program`; tuned on 100 and 1,000 rows, by `make guards`
    cycle_mib_per_row: float = 0.05  # of memory; tuned on the same, by `make guards`
    cycle_per_point: float = 1.2e-5  # CPU seconds of what is written for each; tuned on the same, by `make guards`
    fit_per_row: float = 5e-5  # CPU seconds to fit; tuned on the same, by `make guards`
    work_per_row: float = 8e-6  # CPU seconds of `jkr work`; tuned on the same, by `make guards`
    refit: float = 6e-3  # CPU seconds of a fit from near its end; tuned on 200 rows, by `make guards`
    refit_per_row: float = 5e-6  # and per row; tuned on 1e4 rows, by `make guards`
    profiled: int = 150  # fits of a profile; tuned on 200 and 1,000 rows, by `make guards`
    carried: int = 6  # fits of an uncertain input; theory: two, of three times as many steps each
    fit_per_curve: float = 0.05  # CPU seconds; choice: of 2,000 rows, for the number of processes


TUNING = TableTuning()
KEYS = tuple(NAMES.quantities)


SEPARATED = (
    click.option("--separator", type=click.Choice(list(SEPARATORS)), help="Between the columns [default: found out]."),
    click.option("--decimal", type=click.Choice([".", ","]), help="Decimal mark [default: found out]."),
)


def reading_of(values: dict[str, Any]) -> dict[str, Any]:
    """The values of the options of a reading, KEY=VALUE of several as one mapping."""
    pairs = {"columns", "units", "factors", "zero", "where"} & set(values)
    return values | {name: dict(values[name]) for name in pairs}


reading_options = as_one(
    "reading",
    lambda flip, **values: Reading(flip=frozenset(flip), **reading_of(values)),
    click.option("--column", "columns", multiple=True, type=options.KeyValueType(KEYS),
                 help=f"Column name or number where the header does not tell; keys {', '.join(KEYS)}."),
    click.option("--unit", "units", multiple=True, type=options.ColumnUnitType(),
                 help=f"Unit, whatever the header says, P=nN; keys {', '.join(NAMES.numbers)}, or the name or number "
                 "of a column, deflection=nm."),
    click.option("--factor", "factors", multiple=True, type=options.KeyNumberType(NAMES.numbers),
                 help="Factor of a quantity, on top of its unit and sign, P=1000."),
    click.option("--flip", multiple=True, type=click.Choice(["delta", "P"]),
                 help="Turn the sign of the file, whatever its header says: of loads that count adhesion positive."),
    click.option("--zero", multiple=True, type=options.ScaleType(("delta", "P")),
                 help='Reading at the zero point, subtracted after the flip: delta="1.2 um".'),
    click.option("--contact", type=click.Choice(["auto", "fitted", "as-is", "estimate"]), default="auto",
                 show_default=True, help="Zero points: fitted together with the rest (base line, tilt, contact point; "
                 "auto: of raw records), as-is, or estimated before from the free part of the approach; of raw records "
                 "the same as fitted."),
    click.option("--stiffness", type=options.STIFFNESS,
                 help='The displacement is that of a device (piezo) of this stiffness: P/stiffness is subtracted; it '
                 'makes a force of a deflection. "rigid": nothing is to be subtracted.'),
    click.option("--sensitivity", type=options.SENSITIVITY,
                 help='Of a force microscope, "45 nm/V", where its file lacks it: makes a deflection of volts.'),
    click.option("--format", type=click.Choice(["auto", "text", "afm"]), default="auto", show_default=True,
                 help="auto: by content and ending; afm: .csv and .txt of microscopes (needs afmformats)."),
    *SEPARATED,
    click.option("--rows", type=options.ROWS, help="Only these rows of each curve, from 1: 100..900."),
    click.option("--where", multiple=True, type=options.NAMED,
                 help="Only rows of a segment, of a curve or of one content of a column: segment=retract."),
)  # fmt: skip


def begin_reading(
    verb: str, paths: Sequence[Path], limits: Limits = options.ANY, less: str = "fewer rows", *, per_row: float = 0.0,
    mib_per_row: float = 0.0, per_file: float = 0.0,
) -> None:  # fmt: skip
    """Say what it takes to read measured files, and to do what a ``verb`` does with each row and file [CPU s], where
    that is much; Refusal beyond the ``limits``, with the advice to ask for ``less``."""
    from ..data.measured.amount import rows_expected

    rows = sum(map(rows_expected, paths))
    seconds = (TUNING.per_row + per_row) * rows + per_file * len(paths)
    cost = Forecast(seconds, (TUNING.mib_per_row + mib_per_row) * rows, 0.0)
    options.begin(f"{verb} of about {float(f'{rows:.1g}'):,.0f} rows", cost, limits, less)
