"""``jkr import``: a series that another program computed to a series file."""

from __future__ import annotations

import contextlib
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ..base import InputError, check_series_target, read_bytes
from ..case import Case, CaseModel, LoadingTable, load_case, parse_case, record_of, write_solution
from ..data.foreign import NAMES, SeriesReading, read_series
from ..report import Imported, Output
from ..series import Solution
from .body import Flags, body_options, case_of, named_flags
from .measured import SEPARATED, begin_reading, reading_of
from .options import LENGTH, ONE_FILE, ColumnUnitType, KeyNumberType, KeyValueType, ScaleType, into_file, output_options
from .verb import as_one, verb
from .voice import command_line, give

KEYS = tuple(NAMES.quantities)
SOME_LOADING = b"\n[loading]\ndepth = 1.0\n"  # stands in where a case has none: the table says how far it went


class ZeroType(ScaleType):
    """delta=LENGTH or P=LOAD; a length alone is that of the displacement."""

    def parsed(self, text: str) -> Any:
        return super().parsed(text) if "=" in text else ("delta", LENGTH.parsed(text))


reading_options = as_one(
    "reading",
    lambda **options: SeriesReading(**reading_of(options)),
    click.option("--column", "columns", multiple=True, type=KeyValueType(KEYS),
                 help="Column name or number, delta=U2."),
    click.option("--unit", "units", multiple=True, type=ColumnUnitType(),
                 help="Unit, whatever the header says, P=mN; of a quantity or of a column by name or number."),
    click.option("--factor", "factors", multiple=True, type=KeyNumberType(KEYS), help="Factor of a column, P=180."),
    click.option("--zero", multiple=True, type=ZeroType(("delta", "P")),
                 help='Reading at first touch, subtracted: delta="1.2 um"; a length alone is a displacement.'),
    click.option("--sign", type=click.Choice(["auto", "as-is"]), default="auto", show_default=True,
                 help="auto: a displacement or load that is negative in compression is turned."),
    click.option("--area", type=click.Choice(["surface", "projected"]), default="surface", show_default=True,
                 help="What a contact area is: of the indenter's surface (Eq. A3), or pi a^2."),
    *SEPARATED,
    click.option("--compare/--no-compare", default=True, show_default=True,
                 help="With the exact solution of these bodies: where the edge is between nodes, and the shape."),
    click.option("--sort", is_flag=True, help="Order the rows by displacement first."),
)  # fmt: skip


@verb("table", "import")
@into_file("Series file [default: <table>.h5 here].")
@click.option("--case", type=click.Path(path_type=Path), help="Case with indenter and specimen; it needs no loading.")
@body_options
@reading_options
@output_options(force=ONE_FILE, json="Print the summary as JSON.")
def import_(table: Path, case: Path | None, flags: Flags, reading: SeriesReading, output: Output) -> None:
    """Read the contact radius (or area), displacement and load that another program computed from the text TABLE.

    Columns are known by their names (a, contact radius, CAREA, delta, U2, P, RF2, CFN2, ...) and units in the header,
    "P (mN)" or "P_mN"; say what the header does not. The keys are a, area, delta, P. CalculiX prints the force on its
    wedge of 2 degrees of an axisymmetric body: --factor P=180.

    \b
    jkr import abaqus.rpt --case my.toml --unit delta=um --unit P=mN
    jkr import table.csv -o data.h5 --radius "1 mm" --E "15 kPa" --nu 0.5
    jkr import run.csv --case my.toml --column P=RF2 --column a=4 --factor P=180
    """
    target = output.file(Path(f"{table.stem}.h5"), [table, *([case] if case else [])], check_series_target)
    body = _case(case, flags)
    begin_reading("import", [table])
    solution = read_series(table, body.model.problem(), reading)
    loaded = _with_loading(body, solution)
    solution = replace(solution, record=record_of(loaded))
    write_solution(target, solution, command_line())
    give(Imported(target, solution, table), output.json)


def _case(path: Path | None, body: Flags) -> Case:
    """The case of a file that may lack a loading, or one made of the flags of indenter and specimen."""
    names = named_flags(body)
    if path is None:
        return case_of("import", body, "--case", loading={"depth": 1.0})
    if names:
        raise InputError(f"import: {names.split(', ')[0]} belongs to an import without --case; {path} says it already")
    content = read_bytes(path, "case file")
    with contextlib.suppress(ValueError):  # what is no TOML is reported by parse_case
        if "loading" not in tomllib.loads(content.decode("utf-8")):
            return parse_case(content + SOME_LOADING, str(path), path.parent)
    return load_case(path)


def _with_loading(case: Case, solution: Solution) -> Case:
    """The case with the loading that the table went through."""
    went = solution.problem.loading
    loading = LoadingTable.model_validate({went.to: went.maximum, "points": went.points, "spacing": went.spacing})
    model: CaseModel = case.model.model_copy(update={"loading": loading})
    return Case(model, case.source)
