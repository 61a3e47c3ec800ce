"""What verbs of measured curves start from: how their files are read, what that costs, and the body of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..base.errors import InputError
from ..cli import options
from ..cli.inputs import FLAGS, OPTIONS, SEPARATED, Flags, begin_tables, by_flags, case_of, read_series
from ..cli.options import as_one
from ..methods.protocol import Limits
from ..tables import quantities

if TYPE_CHECKING:
    from ..bodies.indenters import Indenter
    from .curve import Curve, Reading
    from .forward_model import FittedBody

NO_MODULUS = "1 MPa"  # choice: of a specimen whose modulus is not given; no result depends on it
SHALLOW = 0.2  # choice: of the tip radius, to which a body is solved first; the data may ask for more


def body_and_measured(
    body_file: Path, measured: tuple[Path, ...], flags: Flags
) -> tuple[Path | Flags, tuple[Path, ...]]:
    """What describes the body, a file or options, and the measured files: with options all files are measured ones."""
    is_body = body_file.suffix == ".toml"
    if body_file.suffix == ".h5" and body_file.is_file():  # a series, or a measured one
        from ..base.hdf5 import format_of
        from ..case.store import SERIES

        is_body = format_of(body_file) == SERIES
    by_case = not by_flags("fit", flags, [body_file] if is_body else [])
    if by_case and not measured:
        raise InputError("fit: needs --radius and --nu (specimen from options), or a case: jkr fit CASE MEASURED")
    return (body_file, measured) if by_case else (flags, (body_file, *measured))


def fitted_body(source: Path | Flags, slopes: str, limits: Limits) -> FittedBody:
    """The body of a file, or of flags: there a modulus that is not told is 1 MPa, which no result depends on."""
    from .forward_model import body_of

    if isinstance(source, Path):
        return body_of(source if source.suffix == ".toml" else read_series(source), slopes, limits)
    of_flags = partial(case_of, "fit", source, "a case or solution file", NO_MODULUS)
    radius = of_flags(loading={"radius": 1.0}).model.problem().indenter.tip_radius
    method = "closed-form" if source["thickness"] is None else "layered"  # so that no other is imported
    radius = radius or 5e-6  # choice: [m], of a tip that has none
    shallow = of_flags(loading={"radius": SHALLOW * radius}, method=method)
    return replace(body_of(shallow, slopes, limits), moduli_known=source["modulus"] is not None)


# --------------------------------------------------------------------------------------------------
# The options by which verbs read measured curves: one set for all of them.

# What verbs do with the rows of tables.
TABLE_FIT_PER_ROW = 5e-5  # CPU seconds to fit; tuned on tables of 1e5 and 1e6 rows, by `make guards`
TABLE_WORK_PER_ROW = 8e-6  # CPU seconds of `jkr work`; tuned on the same, by `make guards`
TABLE_REFIT = 6e-3  # CPU seconds of a fit from near its end; tuned on 200 rows, by `make guards`
TABLE_REFIT_PER_ROW = 5e-6  # and per row; tuned on 1e4 rows, by `make guards`
TABLE_PROFILED = 150  # fits of a profile; tuned on 200 and 1,000 rows, by `make guards`
TABLE_CARRIED = 6  # fits of an uncertain input; theory: two, of three times as many steps each
TABLE_FIT_PER_CURVE = 0.025  # CPU seconds; choice: of 2,000 rows, for the number of processes


KEYS = quantities("measured")
NUMBERS = [key for key, one in KEYS.items() if one["dimension"]]


force_options = options.several(
    click.option("--load", "force", type=options.LOAD,
                 help='A measured pull-off force, "12 uN": which w does it mean?'),
    click.option("--uncertain", multiple=True, type=options.NAMED,
                 help="With --load: standard deviation of load, R, E, h, nu or E:LAYER, such as load=5%, h=1um."),
)  # fmt: skip
tip_options = as_one("flags", dict, *OPTIONS[:4])
reading_options = as_one(
    "reading",
    "measured.curve:Reading",
    click.option("--column", "columns", cls=options.MappingOption, multiple=True, type=options.KeyValueType(list(KEYS)),
                 help=f"Column name or number where the header does not name it; keys {', '.join(KEYS)}."),
    click.option("--unit", "units", cls=options.MappingOption, multiple=True, type=options.ColumnUnitType(),
                 help=f"Unit, whatever the header says, P=nN; keys {', '.join(NUMBERS)}, or the name or number "
                 "of a column, deflection=nm."),
    click.option("--factor", "factors", cls=options.MappingOption, multiple=True, type=options.KeyNumberType(NUMBERS),
                 help="Multiply a quantity by a factor, in addition to its unit, such as P=1000."),
    click.option("--flip", multiple=True, type=click.Choice(["delta", "P"]),
                 help="Reverse the sign of a column, such as of loads that count adhesion positive."),
    click.option("--zero", cls=options.MappingOption, multiple=True, type=options.ScaleType(("delta", "P")),
                 help='Known contact point or force offset, subtracted (after --flip): delta="1.2 um".'),
    click.option("--contact", type=click.Choice(["auto", "fitted", "as-is", "estimate"]), default="auto",
                 show_default=True, help="Contact point and force offset: fitted, as-is (those of the file), or "
                 "estimate (from the approach before contact). auto and estimate fit them to raw force curves."),
    click.option("--stiffness", type=options.STIFFNESS,
                 help='Of the cantilever or machine, "0.2 N/m": a column of deflections times it is the load, and '
                 'P/stiffness is subtracted from piezo positions. "rigid": nothing is subtracted.'),
    click.option("--sensitivity", type=options.SENSITIVITY,
                 help='Of a force microscope, "45 nm/V", where the file lacks it: deflection over volts.'),
    click.option("--format", type=click.Choice(["auto", "text", "afm"]), default="auto", show_default=True,
                 help="auto: by content and ending; afm: .csv and .txt of microscopes (needs afmformats)."),
    *SEPARATED,
    click.option("--rows", type=options.ROWS, help="Only these rows of each curve, counted from 1, such as 100..900."),
    click.option("--where", cls=options.MappingOption, multiple=True, type=options.NAMED,
                 help="Only rows with this segment, curve number or value of a column: segment=retract."),
)  # fmt: skip


def begin_reading(
    verb: str, paths: Sequence[Path], limits: Limits = options.ANY, less: str = "fewer rows", *, per_row: float = 0.0,
    per_file: float = 0.0,
) -> None:  # fmt: skip
    """Say what it takes to read measured files, and to do what a ``verb`` does with each row and file [CPU s], where
    that is much; Refusal beyond the ``limits``, with the advice to ask for ``less``."""
    from .afm_formats import estimate_rows
    from .files import files_in

    rows = sum(estimate_rows(file) for path in paths for file in (files_in(path) if path.is_dir() else [path]))
    begin_tables(verb, rows, limits, less, per_row=per_row, beside=per_file * len(paths))


def read_for(verb: str, paths: Sequence[Path], reading: Reading, limits: Limits) -> list[Curve]:
    """The measured curves that a ``verb`` draws over its own; Refusal where they take more than the ``limits``."""
    from .curve import Reading
    from .files import read

    if not paths and reading != Reading():
        raise InputError(f"{verb}: options of reading need measured DATA: leave them out")
    reading.refuse_contact(verb)
    begin_reading(verb, paths, limits)
    return [curve for path in paths for curve in read(path, reading)]


def tip_of(verb: str, flags: Flags) -> Indenter | None:
    """The tip of the ``tip_options``; None where none is given."""
    if not any(flags.values()):
        return None
    body = dict.fromkeys(FLAGS) | dict(flags) | {"modulus": "1 MPa", "nu": "0.5"}  # any: the tip is rigid
    return case_of(verb, body, "", loading={"radius": 1.0}).model.problem().indenter
