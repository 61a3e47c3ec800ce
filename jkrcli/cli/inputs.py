"""What verbs start from: a specimen from options instead of a case file, solution files, tables."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import click

from .. import __version__
from ..base.errors import InputError, counted, writable
from ..base.files import check_series_target
from ..base.units import doubtful_modulus
from ..methods.protocol import Forecast, Limits
from ..tables import SEPARATORS
from . import options
from .options import as_one, begin
from .options import flag as option
from .printing import announce, command_line, detail, note, warn

if TYPE_CHECKING:
    from ..adhesion.finite_range import RangeRequest
    from ..case.models import Case
    from ..series import Record, Solution

Flags: TypeAlias = Mapping[str, str | None]  # by their names; None: not given
FLAGS = ("shape", "radius", "half_angle", "cap", "modulus", "nu", "thickness", "base")
SHAPES = {  # from options, and which of them each needs
    **dict.fromkeys(("sphere", "paraboloid", "flat"), ("radius",)),
    "rounded-cone": ("radius", "half_angle"),
    **dict.fromkeys(("cone", "pyramid", "three-sided-pyramid"), ("half_angle",)),
}
CHOICES = {"cap": ("rounded-cone",)}  # flags with a default, and of what
FLAG_OF = {"E" if name == "modulus" else name: name for name in FLAGS[1:]}  # by the last part of a case's key
KEYS = re.compile(rf"\b(?:indenter|specimen)(?:\.half_space|\.layers\[0\])?\.({'|'.join(FLAG_OF)})\b")
OPTIONS = (
    click.option("--shape", type=click.Choice(list(SHAPES)), metavar="SHAPE",
                 help=f"{', '.join(SHAPES)}; paraboloid: of textbook JKR, sphere: exact [default: sphere]."),
    click.option("--radius", help='Its radius, "100 um".'),
    click.option("--half-angle", help='Of a cone, of a pyramid to a face: "35 deg".'),
    click.option("--cap", help="Rounded cone: parabola [default: sphere]."),
    click.option("--E", "modulus", help='Young\'s modulus of the specimen, "5 GPa".'),
    click.option("--nu", help="Poisson's ratio of the specimen."),
    click.option("--thickness", help="A layer of this thickness [default: a half-space]."),
    click.option("--base", help="Under the layer: bonded or frictionless [default: bonded]."),
)  # fmt: skip


body_options = as_one("flags", dict, *OPTIONS)


def flag(name: str) -> str:
    """What a flag is called on the command line."""
    return "--E" if name == "modulus" else option(name)


def named_flags(body: Flags) -> str:
    """The flags that were given, for messages."""
    return ", ".join(flag(name) for name in FLAGS if body.get(name) is not None)


def by_flags(verb: str, body: Flags, files: Sequence[Path]) -> bool:
    """Whether the body is given from options; InputError where it is also given by ``files``."""
    named = named_flags(body)
    if named and files:
        names = ", ".join(map(str, files))
        raise InputError(
            f"{verb}: give a case or solution file or the specimen from options, not both: {names} and {named}"
        )
    return bool(named)


def case_of(verb: str, body: Flags, instead: str, modulus: str | None = None, **keys: Any) -> Case:
    """The case of a specimen from options, with more ``keys``, "loading" among them; the rest as of ``tables_of``.
    InputError names flags, not the keys that they stand for."""
    import tomli_w

    from ..case.models import parse_case

    content = tomli_w.dumps(tables_of(verb, body, instead, modulus) | keys).encode()
    try:
        return parse_case(content, verb)
    except InputError as error:
        raise InputError([KEYS.sub(lambda key: flag(FLAG_OF[key[1]]), line, count=1) for line in error.lines]) from None


def tables_of(verb: str, body: Flags, instead: str, modulus: str | None) -> dict[str, Any]:
    """Indenter and specimen of a case from flags; InputError names missing flags, and what may be given ``instead``.

    ``modulus``: the specimen's where there is no flag for it; None: the flag is required.
    """
    values = {**body, "modulus": body["modulus"] or modulus}
    texts = {name: None if value is None else writable(value) for name, value in values.items()}
    shape = texts["shape"] or "sphere"
    sizes = SHAPES[shape]
    choices = [name for name, shapes in CHOICES.items() if shape in shapes and texts[name] is not None]
    optional = [name for name in ("radius", "half_angle", *CHOICES) if texts[name] is not None]
    if unused := [flag(name) for name in optional if name not in (*sizes, *choices)]:
        raise InputError(f"{verb}: a {shape} has no {unused[0]}: leave it out, or give another --shape")
    missing = [flag(name) for name in (*sizes, "modulus", "nu") if texts[name] is None]
    if missing:
        either = f"needs {instead}, or the specimen from options: " if instead else ""
        raise InputError(f"{verb}: {either}{', '.join(missing)} missing")
    if texts["base"] is not None and texts["thickness"] is None:
        raise InputError(f"{verb}: --base needs --thickness: a half-space has no base")
    entries = {name: number_or_text(text) for name, text in texts.items()}
    for name in ("radius", "thickness"):
        size = entries[name]
        if isinstance(size, float) and size >= 0.1:  # choice: [m], larger than what is pressed
            warn(f"{flag(name)} {texts[name]} without a unit is {size:g} m: give its unit, {flag(name)} "
                 f'"{texts[name]} um"')  # fmt: skip
    E = entries["modulus"]
    if isinstance(E, float) and E > 0 and (doubt := doubtful_modulus(E)):
        warn(f"--E: {doubt}")
    material = {"E": E, "nu": entries["nu"]}
    specimen: dict[str, Any] = {"half_space": material}
    if entries["thickness"] is not None:
        layer = material | {"thickness": entries["thickness"]}
        specimen = {"base": texts["base"] or "bonded", "layers": [layer]}
    indenter = {"shape": shape} | {name: entries[name] for name in (*sizes, *choices)}
    return {"indenter": indenter, "specimen": specimen}


def number_or_text(text: str | None) -> float | str | None:
    """A bare number as one, so that it is SI; else the text, for the case reader to judge."""
    with contextlib.suppress(ValueError, TypeError):
        return float(text)  # type: ignore[arg-type]
    return text


# --------------------------------------------------------------------------------------------------
# Solution files as the verbs read them, and how far they go, in words.

PER_FILE = 0.012  # CPU seconds to read a series; tuned on 300 files, by `make guards`
IMPORTED = "jkr import"  # how the command line of a series begins that no case gives again


def series_file(path: Path) -> Path:
    """The solution file meant by ``path``: itself, or for a case what ``jkr run`` makes of it, ``<case>.h5`` here.

    That is solved now unless it is there already, and says so; a file that jkr did not write is left alone, and so is
    an imported series of another case.
    """
    if path.suffix != ".toml":
        return path
    from ..case import models, store

    case, target = models.load_case(path), Path(f"{path.stem}.h5")
    check_series_target(target, False, [path])
    existing = _solved(target, case)
    if existing is not None:
        detail(f"{path}: solution read from {target} (method {existing.method})")
        if _adhesion(existing.record) != _adhesion(store.record_of(case)):
            loading = cast("Case", existing.record.case).model.loading  # of an import that of its table
            record = store.record_of(replace(case, model=case.model.model_copy(update={"loading": loading})))
            store.write_solution(target, replace(existing, record=record), existing.record.command_line)
        return target

    choice, solution = store.solve(case, announce=note)
    store.write_solution(target, solution, command_line())
    note(f"{path}: solved by method {choice.name}, written {target}")
    for remark in case.remarks:
        warn(remark)
    return target


def _adhesion(record: Record) -> tuple[object, ...]:
    return record.w, record.z0, record.stress, record.length


def _solved(target: Path, case: Case) -> Solution | None:
    """What ``target`` holds where that is a series of the same body, loading and method by this release, or one of the
    same body that was imported."""
    from ..case.models import Case, other_tables
    from ..case.store import read_solution

    try:
        solution = read_solution(target, with_pressure=True) if target.exists() else None
    except InputError:
        return None
    if solution is None or not isinstance(solution.record.case, Case):
        return None
    imported = solution.record.command_line.startswith(IMPORTED)
    apart = {"title", "adhesion"} | other_tables(solution.method) | ({"loading", "method"} if imported else set())
    there, wanted = (one.model.model_dump(exclude=apart) for one in (solution.record.case, case))
    if there == wanted and (imported or solution.record.versions.get("jkr") == __version__):
        return solution
    if imported:
        raise InputError(f"{target}: an imported solution of another case: give {target} itself, or move it away")
    return None


def read_files(verb: str, paths: Sequence[Path]) -> tuple[tuple[Path, ...], list[Solution]]:
    """The solution files that are meant by ``paths``, and what they hold; said beforehand where they are many."""
    announce_files(verb, paths)
    files = tuple(map(series_file, paths))
    return files, [read_series(path) for path in files]


def announce_files(verb: str, paths: Sequence[Path]) -> None:
    """Say what it takes a ``verb`` to read solution files, where that is much."""
    announce(f"{verb} of {counted(len(paths), 'file')}", PER_FILE * len(paths))


def read_series(path: Path) -> Solution:
    """What the solution file at ``path`` holds; a file that damage could have changed unnoticed is warned of."""
    from ..adhesion.contact_shape import ContactShape
    from ..case.store import NO_DIGEST, read_solution

    solution = read_solution(path)
    if NO_DIGEST in solution.warnings:
        warn(f"{path}: {NO_DIGEST}")
    shape = ContactShape.of(solution.facts, solution.problem.is_half_space)
    if shape and click.get_current_context().info_name not in ("transform", "pull-off"):  # which state it
        warn(f"{path}: {shape.words()}; no error here includes it")
    return solution


def warn_of_constant_moduli(*solutions: Solution) -> None:
    """Say of each specimen that relaxes what the numbers of a verb mean that does not follow its moduli over time."""
    from ..bodies.problem import relaxing

    for solution in solutions:
        for text in relaxing(solution.problem.specimen.relaxation):
            warn(f"{solution.record.path}: {text}")


def works_of(solution: Solution, option: str = "--w") -> tuple[float, ...]:
    """The works of adhesion [J/m^2] that the case names; InputError, with the ``option`` that helps, where none."""
    if not solution.record.w:
        raise InputError(f"{solution.record.path}: its case names no work of adhesion: give {option}")
    return solution.record.w


def body_and_work(verb: str, path: Path, work: float | None, ranged: bool = False) -> tuple[Path, Solution, float]:
    """The solution file meant by ``path``, what it holds, and the ``work`` of adhesion [J/m^2] or the first that
    its case names, 0, with a note, where it names none; Refusal by a ``verb`` that is not ``ranged``, see
    ``without_range``."""
    from ..adhesion.finite_range import without_range

    file = series_file(path)
    solution = read_series(file)
    warn_of_constant_moduli(solution)
    if not ranged:
        without_range(solution.record, verb)
    if work is None and not solution.record.w:
        note(f"{solution.record.path}: its case names no work of adhesion: the contact without adhesion, or give --w")
    return file, solution, (*solution.record.w, 0.0)[0] if work is None else work


def begin_curves(
    verb: str, solutions: Sequence[Solution], works: Sequence[Sequence[float]], limits: Limits,
    ranges: Sequence[RangeRequest] = (), tables: bool = False, figures: bool = False, devices: int = 0,
    beside: float = 0.0,
) -> None:  # fmt: skip
    """Say what the curves of a ``verb`` will cost together, with the ``ranges`` of adhesion of each solution (default:
    none), read off for so many ``devices``, and what takes so many CPU seconds ``beside``, where that is much; Refusal
    beyond the ``limits``."""
    from ..adhesion.finite_range import RangeRequest
    from ..resolve.analysis import forecast

    ranges = ranges or [RangeRequest()] * len(solutions)
    costs = [forecast(*each, tables, figures, devices) for each in zip(solutions, works, ranges, strict=True)]
    total = Forecast(beside + sum(cost.seconds for cost in costs), max(cost.memory_mib for cost in costs), 0.0)
    rows = sum(solution.increments.a.size for solution in solutions)
    under = f" under {counted(devices, 'control')}" if devices else ""
    what = f"{verb} of {counted(rows, 'row')} for {counted(sum(map(len, works)), 'work')} of adhesion{under}"
    less = f"fewer rows, files{', controls' if devices else ''} or works of adhesion, or leave out the plots"
    begin(what, total, limits, less)


# --------------------------------------------------------------------------------------------------
# Tables as the verbs read them.

TABLE_PER_ROW = 3e-6  # CPU seconds to read; tuned on tables of 1e5 and 1e6 rows, by `make guards`
TABLE_MIB_PER_ROW = 7e-4  # of memory; tuned on the same, by `make guards`
SEPARATED = (
    click.option("--separator", type=click.Choice(list(SEPARATORS)), help="Between the columns [default: detected]."),
    click.option("--decimal", type=click.Choice([".", ","]), help="Decimal mark [default: detected]."),
)


def begin_tables(
    verb: str, rows: float, limits: Limits = options.ANY, less: str = "fewer rows", *, per_row: float = 0.0,
    mib_per_row: float = 0.0, beside: float = 0.0,
) -> None:  # fmt: skip
    """Say what it takes to read so many ``rows`` of tables and to do what a ``verb`` does with each, and ``beside``
    [CPU s], where that is much; Refusal beyond the ``limits``, with the advice to ask for ``less``."""
    cost = Forecast((TABLE_PER_ROW + per_row) * rows + beside, (TABLE_MIB_PER_ROW + mib_per_row) * rows, 0.0)
    options.begin(f"{verb} of about {float(f'{rows:.1g}'):,.0f} rows", cost, limits, less)
