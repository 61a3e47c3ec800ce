"""Verbs of cases: ``new``, ``check`` and ``run``, and ``import`` of others' series."""

from __future__ import annotations

import contextlib
import time
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base.errors import InputError, counted, did_you_mean
from ..base.files import check_series_target, check_target, read_bytes, write_bytes
from ..methods.protocol import METHODS, Limits, long_look
from ..report.result import Output
from ..tables import quantities
from . import options
from .inputs import SEPARATED, Flags, begin_tables, body_options, case_of, named_flags
from .printing import announce, command_line, detail, give, note, say

if TYPE_CHECKING:
    from ..adhesion.roughness import Roughness
    from ..case.models import Case
    from ..resolve.foreign import SeriesReading

# --------------------------------------------------------------------------------------------------
# Verbs of cases: ``new`` and ``run``, and ``import`` of others' series.


@options.verb("case")
@options.into_file("Solution file [default: <case>.h5 here].")
@click.option("--method", type=options.MethodType(["auto", *METHODS]), help="Replaces the case's; auto: the simplest.")
@click.option("--tolerance", type=float,
              help="Relative error allowed in the load at given depth, for any method, instead of the case's."
)  # fmt: skip
@options.limits_options
@options.output_options(force=options.ONE_FILE, json="Print the summary as JSON.")
def run(case: Path, method: str | None, tolerance: float | None, limits: Limits, output: Output) -> None:
    """Solve CASE (TOML) without adhesion: load, displacement and contact radius, with their errors, to HDF5.

    One solution serves every work of adhesion: jkr transform reads it.

    \b
    jkr run cases/halfspace.toml
    jkr run my.toml --method fem -o results/my.h5
    """
    from ..case import models, store
    from ..report.solved import Solved
    from ..resolve.sticking import effect_facts, sticking_effect

    start = time.process_time()
    loaded = models.load_case(case)
    if tolerance is not None:
        loaded = loaded.with_tolerance(tolerance, method or loaded.model.method)
    target = output.file(Path(f"{case.stem}.h5"), [case], check_series_target)
    choice, solution = store.solve(loaded, method, limits, note)
    effect = sticking_effect(solution.problem, float(solution.series.a[-1]), ())
    solution = replace(solution, facts={**solution.facts, **effect_facts(effect)})
    for stage, used in solution.timings.items():
        detail(f"{stage}: {used:.3f} s CPU")
    store.write_solution(target, solution, command_line())
    seconds = time.process_time() - start
    give(Solved(target, solution, choice, effect, seconds, tolerance, loaded.remarks), output.json)


# --------------------------------------------------------------------------------------------------
# ``jkr new``: a commented case file to start from.

TEMPLATE = Path(__file__).with_name("new.toml")


def _example(name: str) -> Path:
    """A shipped case or measured curve: of a checkout, or among the data files of an installation."""
    from importlib import metadata

    installed = [file for each in metadata.distributions(name="jkrcli") for file in each.files or ()]
    files = [Path(str(file.locate())) for file in installed if "share/jkrcli/cases" in file.as_posix()]
    if not files:
        folder = Path(__file__).parents[2] / "cases"
        files = [*folder.glob("*.toml"), *folder.glob("measured/*")]
    known = {path.stem: path for path in sorted(files, key=lambda path: (path.suffix != ".toml", path.stem))}
    if name not in known:
        raise InputError(f'--example: unknown example "{name}"{did_you_mean(name, known)} ({", ".join(known)})')
    return known[name]


@options.verb("[file]")
@click.option("--example", metavar="NAME", help="A shipped case or force curve [default file: its name here].")
@click.option("--force", is_flag=True, help="Replace an existing file.")
def new(file: Path | None, example: str | None, force: bool) -> None:
    """Write a commented case, ready to edit and run, to FILE; with --example a shipped case or force curve.

    \b
    jkr new my.toml && jkr check my.toml && jkr transform my.toml
    jkr new --example gel
    """
    source = TEMPLATE if example is None else _example(example)
    if file is None and example is None:
        raise InputError("new: give the FILE to write, such as my.toml, or --example")
    target = file or Path(source.name)
    if target.suffix != source.suffix:
        raise InputError(f"{target}: the name must end in {source.suffix}")
    if target.exists() and not force:
        raise InputError(f"{target}: exists; give --force to replace it, or another name")
    check_target(target, force)
    write_bytes(target, source.read_bytes())
    say(f"written {target}; next: {'edit it, jkr check' if target.suffix == '.toml' else 'jkr look'} {target}")


# --------------------------------------------------------------------------------------------------
# ``jkr import``: a series that another program computed to a solution file.

KEYS = tuple(quantities("computed"))
SOME_LOADING = b"\n[loading]\ndepth = 1.0\n"  # stands in where a case has none: the table says how far it went


class ZeroType(options.ScaleType):
    """delta=LENGTH or P=LOAD; a length alone is that of the displacement."""

    def parsed(self, text: str) -> Any:
        return super().parsed(text) if "=" in text else ("delta", options.LENGTH.parsed(text))


class ShapeType(options.ParsedType):
    """disc, any or ellipse=R1/R2."""

    name = "SHAPE"

    def parsed(self, text: str) -> str:
        from ..adhesion.contact_shape import ratio_of

        ratio_of(text)
        return text


reading_options = options.as_one(
    "reading",
    "resolve.foreign:SeriesReading",
    click.option("--column", "columns", cls=options.MappingOption, multiple=True, type=options.KeyValueType(KEYS),
                 help="Column name or number, delta=U2."),
    click.option("--unit", "units", cls=options.MappingOption, multiple=True, type=options.ColumnUnitType(),
                 help="Unit, whatever the header says, P=mN; of a quantity or of a column by name or number."),
    click.option("--factor", "factors", cls=options.MappingOption, multiple=True, type=options.KeyNumberType(KEYS),
                 help="Factor of a column, P=180."),
    click.option("--zero", cls=options.MappingOption, multiple=True, type=ZeroType(("delta", "P")),
                 help='Contact point, subtracted: delta="1.2 um"; a length without a key is delta.'),
    click.option("--sign", type=click.Choice(["auto", "as-is"]), default="auto", show_default=True,
                 help="auto: a displacement or load that is negative in compression is turned."),
    click.option("--area", type=click.Choice(["auto", "surface", "projected"]), default="auto", show_default=True,
                 help="Meaning of a contact area: area of the indenter's surface (Eq. A3), or pi a^2. auto: pi a^2 "
                 "where the exact solution of these bodies says so."),
    *SEPARATED,
    click.option("--compare/--no-compare", default=True, show_default=True,
                 help="With the exact solution of these bodies: where the edge is between nodes, and the shape."),
    click.option("--nodes", type=options.FileType(),
                 help="Radii of all nodes of the mesh at the contact, a table of one column, where contact radii are "
                 "those of the outermost node in contact. Default: the series tells them."),
    click.option("--contact-shape", type=ShapeType(), default="disc", show_default=True,
                 help="Of a contact that grows: any (no disc, a = sqrt(A/pi)), or ellipse=R1/R2 of the tip's radii."),
    click.option("--sort", is_flag=True, help="Order the rows by displacement first."),
)  # fmt: skip


@options.verb("table", "import")
@options.into_file("Solution file [default: <table>.h5 here].")
@click.option("--case", type=options.FileType(), help="Case with indenter and specimen; it needs no loading.")
@body_options
@reading_options
@options.output_options(force=options.ONE_FILE, json="Print the summary as JSON.")
def import_(table: Path, case: Path | None, flags: Flags, reading: SeriesReading, output: Output) -> None:
    """Read P, delta and a (or the contact area) that another program computed from TABLE, and write a solution file.

    The header names the columns (a, CAREA, delta, U2, P, RF2, ...) and their units, "P (mN)"; otherwise give --column
    a=NAME and --unit P=mN. The program compares loads and radii with the exact solution of the specimen. CalculiX
    prints the force on a wedge of 2 degrees: give --factor P=180. The verb transform reads the written solution.

    \b
    jkr import abaqus.rpt --case my.toml --unit delta=um --unit P=mN
    jkr import table.csv --radius "1 mm" --E "15 kPa" --nu 0.5 -o data.h5
    """
    from ..case import models, store
    from ..report.solved import Imported
    from ..resolve.foreign import read_series
    from ..tables.text import rows_of_text

    target = output.file(Path(f"{table.stem}.h5"), [table, *([case] if case else [])], check_series_target)
    body = _case(case, flags)
    begin_tables("import", rows_of_text(table))
    solution = read_series(table, body.model.problem(), reading)
    # The case with the loading that the table went through.
    went = solution.problem.loading
    loading = models.LoadingTable.model_validate(
        {went.to: went.maximum, "points": went.points, "spacing": went.spacing}
    )
    model: models.CaseModel = body.model.model_copy(update={"loading": loading})
    loaded = models.Case(model, body.source)
    solution = replace(solution, record=store.record_of(loaded))
    store.write_solution(target, solution, command_line())
    give(Imported(target, solution, table), output.json)


def _case(path: Path | None, body: Flags) -> Case:
    """The case of a file that may lack a loading, or one made of the flags of indenter and specimen."""
    from ..case.models import load_case, parse_case

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


# --------------------------------------------------------------------------------------------------
# ``jkr check``: what a case needs and what to expect, without solving it.


@options.verb("case")
@options.roughness_options
@options.json_option
def check(case: Path, roughness: Roughness | None, as_json: bool) -> None:
    """Check CASE before it is solved: the method that it needs, what each would cost, the pull-off force to expect, and
    how large the neglected effects are.

    The numbers come from a coarse solution of the laterally unbounded specimen. Nothing is written.

    \b
    jkr check cases/thin-layer.toml
    jkr check my.toml -v                    all neglected effects, all methods
    """
    from ..case.models import load_case
    from ..report.check import Check
    from ..resolve.neglected import seconds_of_effects

    loaded = load_case(case)
    problem = loaded.model.problem()
    if words := long_look(problem):
        note(words)
    works = loaded.model.adhesion.w
    layers = f"of {counted(len(problem.layers), 'layer')} " * (len(problem.layers) > 1)
    what = f"check {layers}for {counted(len(works), 'work', 'works')} of adhesion"
    announce(what, seconds_of_effects(problem, works))
    give(Check.of(case, loaded, roughness), as_json)
