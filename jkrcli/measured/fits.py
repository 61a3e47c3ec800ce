"""``jkr fit``: E*, w and the contact point from measured curves."""

from __future__ import annotations

import contextlib
import json
import os
import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from ..base import files
from ..base.errors import InputError, JkrError, SolveError, counted
from ..base.executors import executor
from ..base.files import Piped, beside, together, write_text
from ..base.process import SILENCE, duration, one_thread
from ..base.registry import Result
from ..base.units import show
from ..base.wings import is_offered, offered
from ..bodies.problem import RADIUS, RELAXATIONS
from ..cli import options
from ..cli.inputs import Flags
from ..cli.options import Parallel, begin, flag
from ..cli.printing import command_line, give, note, progress, say, warn
from ..methods.protocol import Forecast, Limits
from ..report.result import PICTURES, SHOWN, Files, Output
from ..tables.text import some
from . import files as measured
from .batch import constants_apart, header_errors, read_batch
from .curve import Curve, Reading
from .files import folders_of, holds_map
from .forward_model import FittedBody, refuse_full_end
from .joint import joint_fit, shared_of, with_radii
from .parameters import ALIAS, Answer
from .procedure import Failure, fit_all, friction_warnings, memory_of, planned, preferences
from .readings import (
    NO_MODULUS,
    TABLE_CARRIED,
    TABLE_FIT_PER_CURVE,
    TABLE_FIT_PER_ROW,
    TABLE_PROFILED,
    TABLE_REFIT,
    TABLE_REFIT_PER_ROW,
    begin_reading,
    body_and_measured,
    fitted_body,
)
from .report import SYMBOLS, Fits, alternatives_table, plan_table
from .result import Fit, attempted, left_out
from .segmentation import segment_force_curve
from .settings import EACH, LAW, RELAXATION, SHARED, TENSION, USUALLY_FREE, Settings, check_unused, settings_of

# --------------------------------------------------------------------------------------------------
# ``jkr fit`` of records together: what they share, a law of w over the edge's speed, a surface tension; and of laws
# of relaxation.

Beside = TypeVar("Beside")


Pairs: TypeAlias = tuple[tuple[str, Any], ...]  # NAME=VALUE


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """What was asked of a fit, by the options of the same names."""

    free: tuple[tuple[str, ...], ...]
    fix: Pairs
    start: Pairs
    bound: Pairs
    law: str | None = None
    relaxation: str | None = None
    terms: int | None = None
    segment: str | None
    base_line: str
    branch: str
    noise: Pairs
    loss: str
    confidence: str
    model: str
    rivals: bool
    plan: bool
    level: float
    samples: int
    seed: int
    shared: tuple[tuple[str, ...], ...]
    own: tuple[tuple[str, ...], ...]
    tip_radius: tuple[float, ...]
    surface: str | None
    uncertain: Pairs
    grid: tuple[int, int] | None
    sample: str | None = None
    report: bool = False


@dataclass(frozen=True, eq=False)
class FitRequest:
    """What is fitted to what, how the files are read, and where it goes; ``names``: of what is free beside the usual;
    ``body_words``: the ``body`` in words; ``inputs``: files not to write over; ``samples``, ``report``: files on them,
    if any."""

    body: FittedBody
    measured: Sequence[Path]
    reading: Reading
    names: Sequence[str]
    options: FitOptions
    targets: Files
    body_words: str
    output: Output
    inputs: Sequence[Path]
    samples: Files | None = None
    report: Files | None = None

    def __post_init__(self) -> None:
        refuse_full_end(self.body)

    def curves(self, beside: Sequence[Beside]) -> tuple[list[Curve], list[Beside]]:
        """The curves in all files, each with what stands ``beside`` its file; InputError where one cannot be read."""
        pairs = [(item, one) for path, one in zip(self.measured, beside, strict=True)
                 for item in measured.each(path, self.reading)]  # fmt: skip
        for item, _ in pairs:
            if isinstance(item, InputError):
                raise item
        return [item for item, _ in pairs if not isinstance(item, InputError)], [one for _, one in pairs]

    def conclude(self, fit: Callable[[], Answer]) -> None:
        """One ``fit`` of all curves: its table, summary and, where it has one, picture."""
        try:
            with one_thread():
                result = replace(fit(), body=self.body_words)
        except SolveError as error:
            raise InputError(f"{self.measured[0]}: {error}") from None
        self.write(result)

    def write(self, result: Result) -> None:
        """The files of a ``result``, and what is said of it."""
        summary = dict(result.summary()) | selection(self.targets, self.inputs)
        self.targets.write(result.columns, summary, self.targets.draw(result.figure))
        give(result, self.output.json, f"  written {self.targets}")


def selection(targets: Files, inputs: Sequence[Path]) -> dict[str, list[str]]:
    """What a summary says of the ``inputs``: their places as seen from its own; nothing of what came through a pipe."""
    if any(isinstance(path, Piped) for path in inputs):
        return {}
    return {"inputs": [Path(os.path.relpath(path, targets.stem.parent)).as_posix() for path in inputs]}


def refuse_another_selection(targets: Files, inputs: Sequence[Path], force: bool) -> None:
    """InputError where the results of other inputs stand that nobody asked to replace."""
    path, mine = targets[".json"], selection(targets, inputs).get("inputs")
    if force or mine is None:
        return
    with contextlib.suppress(OSError, ValueError):
        _, mark, rest = path.read_text(encoding="utf-8").partition('"inputs": ')
        theirs = json.JSONDecoder().raw_decode(rest)[0] if mark else mine
        if theirs != mine:
            others = ", ".join([str(name) for name in theirs if name not in mine] or theirs)
            raise InputError(f"{path}: holds results of other inputs ({others}): give another folder with -o, or "
                             "--force to replace it")  # fmt: skip


def sample_names(paths: Sequence[Path], pattern: str | None) -> Callable[[Path, str], str] | None:
    """The name of the sample of a curve by the path that was given and the place of the curve, "folder/a.txt": what the
    ``pattern`` finds there, its first group, or else the folder or map, where several are given; None: no samples."""
    if pattern is None:
        if len(paths) < 2 or not any(map(holds_map, paths)):
            return None
        short = [path.name if path.is_dir() else path.stem for path in map(Path.absolute, paths)]
        names = dict(zip(paths, map(str, paths) if len(set(short)) < len(short) else short, strict=True))
        return lambda path, where: names[path]
    try:
        compiled = re.compile(pattern)
    except re.error as error:
        raise InputError(f'fit: --sample: "{pattern}" is no regular expression ({error})') from None

    def found(path: Path, where: str) -> str:
        if (match := compiled.search(where)) is None:
            raise InputError(f'{where}: has no sample, --sample "{pattern}" finds nothing in this name')
        return match[1] if compiled.groups else match[0]

    return found


def fit_joint(request: FitRequest, settings: Settings) -> None:
    """What all records have in common, from all of them together."""
    shared, own = (_flat(groups) for groups in (request.options.shared, request.options.own))
    names = shared_of(shared, own, settings)
    curves, bodies = request.curves(with_radii(request.body, request.options.tip_radius, len(request.measured)))
    request.conclude(lambda: joint_fit(bodies, curves, settings, names))


def has_tension(request: FitRequest) -> bool:
    """Whether surface tension has a part in the fit."""
    named = TENSION in request.names or TENSION in dict(request.options.fix)
    return named or request.body.problem.specimen.surface_tension > 0


def fit_tension(request: FitRequest) -> None:
    """The surface tension, E*, w and zeros from records by tips of several radii."""
    from .surface_tension import known_values, radii_of, tension_fit

    problem, level = request.body.problem, request.options.level
    fixed = known_values(problem, request.names, request.options.fix)
    curves, tips = request.curves(radii_of(problem, request.options.tip_radius, len(request.measured)))
    request.conclude(lambda: tension_fit(problem, curves, tips, fixed, level))


# --------------------------------------------------------------------------------------------------
# ``jkr fit`` of curves one by one: their table, summary, archive and pictures.

Outcome: TypeAlias = "Fit | Failure"
Pictures: TypeAlias = "list[tuple[Outcome, Files]]"
UNNAMED = "unknown"  # sample of a file that cannot be read, where files name theirs
FEWER = "fewer rows, curves or samples"
FORECAST_FEW = 8  # choice: curves from which the time of a folder is forecast; fitted together they cost as all do
CALIBRATED_BY = re.compile(r"\b(stiffness|sensitivity|deflection)\b")  # in a flag of a curve
FORECAST_LOT = 0.05  # choice: seconds between curves that were not fitted together


def refits_of(confidence: str, samples: int, uncertain: int) -> int:
    """How often a curve is fitted anew for its intervals, and for as many ``uncertain`` inputs."""
    anew = {"covariance": 0, "profile": TABLE_PROFILED, "bootstrap": samples}
    return anew[confidence] + TABLE_CARRIED * uncertain


@contextlib.contextmanager
def mended(label: str, total: int, seconds: float) -> Iterator[Callable[[bool], None]]:
    """Progress of fits whose forecast is mended: a note where those done so far tell that what is left takes more than
    twice as long as was told. Several are done at once: what one lot took is known as the next one ends."""
    start, told, done, last = time.monotonic(), seconds, 0, 0.0
    with progress(label, total, seconds) as step:

        def next_one(failed: bool) -> None:
            nonlocal told, done, last
            step(failed)
            now = time.monotonic() - start
            left = last / max(done, 1) * (total - done)
            if now > last + FORECAST_LOT and left > max(2 * (told - last), SILENCE):
                told = last + left
                note(f"{label}: {done} of {total} done, about {duration(left)} to go")
            done, last = done + 1, now

        yield next_one


def fit_curves(
    request: FitRequest, bodies: list[FittedBody], settings: Settings, refits: int, limits: Limits,
    parallel: Parallel,
) -> None:  # fmt: skip
    """Each curve on each of the ``bodies``, which are one under different surfaces: table, archive and pictures."""

    output, asked = request.output, request.options
    batch = read_batch(request.measured, request.reading, asked.grid)
    read = batch.read
    curves, unread = [one for found, _ in read for one in found], [line for _, lines in read for line in lines]
    name, names, unread_names = sample_names(request.measured, asked.sample), list[str](), list[str]()
    for path, (found, lines) in zip(request.measured, read, strict=True):
        if name is not None and len(bodies) == 1:
            names += [name(path, one.where) for one in found]
            unread_names += [name(path, Failure(None, (line,)).where) for line in lines]
    in_files = [one.sample for one in curves]
    if asked.sample is None and len(bodies) == 1 and all(in_files) and len(set(in_files)) > 1:
        names, unread_names = in_files, [UNNAMED] * len(unread)
        stem = request.targets.stem
        files_of = stem.with_name(f"{stem.name.removesuffix('fit')}samples")
        request = replace(request, samples=request.samples or output.files(files_of, (".csv", ".png"), request.inputs))
    seconds = sum(TABLE_FIT_PER_CURVE + refits * (TABLE_REFIT + TABLE_REFIT_PER_ROW * len(one)) for one in curves)
    forecast = Forecast(len(bodies) * seconds, memory_of(curves, len(bodies), parallel[0]), 0.0)
    begin(f"fit of {counted(len(curves), 'curve')}", forecast, limits, FEWER)
    of_headers = {name: size for name, size in header_errors(curves).items() if name not in settings.uncertain}
    settings = replace(settings, uncertain={**of_headers, **settings.uncertain})
    groups, each = [(bodies, curves, settings)], [list[Outcome]() for _ in bodies]
    if asked.tip_radius:  # each file or folder by its tip
        tips = [*zip(*(with_radii(one, asked.tip_radius, len(read)) for one in bodies), strict=True)]
        of_tips = [_settings(replace(request, body=tip[0]), settings.contact) for tip in tips]
        groups = [([*tip], found, replace(how, uncertain={**of_headers, **how.uncertain}))
                  for tip, (found, _), how in zip(tips, read, of_tips, strict=True)]  # fmt: skip
    for of_tip, part, how in groups:
        fitted = _fit_group(of_tip, part, how, forecast, limits, parallel)
        for one, items, more in zip(of_tip, each, fitted, strict=True):
            items += [planned(one, item) if asked.plan and isinstance(item, Fit) else item for item in more]
    for items in each:
        items += [Failure(None, (line,)) for line in unread]
    outcomes = [item for items in each for item in items]
    if asked.rivals and not any(isinstance(item, Fit) and item.verdict for item in outcomes):
        raise InputError("fit: --rivals is for raw force curves, and none of these is one: leave it out")
    reasons = [line for item in each[0] if isinstance(item, Failure) for line in item.lines]
    pictures = _pictures(request, each, bodies) if output.plots else []
    left, none, several = list[str](), list[str](), len(bodies) > 1
    prefer, friction = partial(preferences, outcomes), partial(friction_warnings, request.body, outcomes)
    what, words = ("which surface is preferred", prefer) if several else ("whether sticking matters", friction)
    told = attempted(what, lambda: list(words()), none, left)
    preferred, friction_words = (told, none) if several else (none, told)
    remarks, places = [*batch.notes, *friction_words], ", ".join(filter(None, dict.fromkeys(batch.places)))
    own = [RADIUS] * (len(asked.tip_radius) > 1) + constants_apart(curves, names)
    result = Fits(outcomes, request.body_words, remarks, [*names, *unread_names], own)
    # How many curves were converted with which stiffness and sensitivity, in sentences
    flags = Counter(flag for one in curves for flag in one.flags if CALIBRATED_BY.search(flag))
    calibration = [f"{flag[:1].upper()}{flag[1:]} ({counted(times, 'curve')})."
                   for flag, times in flags.most_common(SHOWN)]  # fmt: skip
    count, more_files = _write(request, result, reasons, pictures, left, calibration, places)
    for line in [*(f"skipped: {line}" for line in some(reasons)), *left]:
        warn(line)
    drawn = f", {counted(count, 'picture')}" if count else ""
    rest = f"; the table has all {len(result.outcomes):,} curves" if len(result.fits) > SHOWN else ""
    give(result, output.json, f"  written {request.targets}{drawn}{more_files}{rest}")
    for item in result.fits[:SHOWN] if not output.json else []:
        if lines := [*(alternatives_table(item) if asked.rivals else []), *plan_table(item)]:
            say("\n".join(lines))
    for line in preferred:
        (note if output.json else say)(line)


def _fit_group(
    bodies: Sequence[FittedBody], curves: list[Curve], settings: Settings, forecast: Forecast, limits: Limits,
    parallel: Parallel,
) -> list[list[Outcome]]:  # fmt: skip
    """The fits of all curves on each of the ``bodies``; of many curves the first tell how long the others take."""
    each, few = [list[Outcome]() for _ in bodies], FORECAST_FEW if len(curves) > 2 * FORECAST_FEW else 0
    seconds = forecast.seconds / len(bodies)
    for part in (curves[:1], curves[1 : few + 1]) if few else ():  # the first solves the bodies deep enough
        start = time.process_time()
        with executor(1) as here:
            for one, items in zip(bodies, each, strict=True):
                items += fit_all(one, part, settings, here)
        seconds = (time.process_time() - start) / len(part) / len(bodies) * len(curves)
    begin(f"fit of {counted(len(curves), 'curve')}", replace(forecast, seconds=seconds * len(bodies)), limits, FEWER)
    for one, items in zip(bodies, each, strict=True):
        with executor(*parallel, mended, seconds) as pool:
            items += fit_all(one, curves[len(items) :], settings, pool)
    return each


def _write(
    request: FitRequest, result: Fits, reasons: list[str], pictures: Pictures, left: list[str],
    calibration: Sequence[str], places: str,
) -> tuple[int, str]:  # fmt: skip
    """Write table, summary, archive and pictures, but for what goes to ``left`` with the reason; how many pictures, and
    what is said of the page of curves and the map. InputError, when all that can be written is, where no curve could be
    used."""
    from . import archive

    if all(isinstance(item, Failure) and item.curve is None for item in result.outcomes):
        raise InputError(some(reasons))
    targets, output = request.targets, request.output
    summary = result.summary() | selection(targets, request.inputs)
    maps = archive.maps_of(result.outcomes, result.sample)
    one_surface = len({item.surface for item in result.fits}) == 1
    alone = not maps and (len(result.outcomes) < archive.LEAST_CURVES or not one_surface or bool(result.sample))
    drawn: list[tuple[str, archive.Map | None]] = [
        (f"the map{f' of {name}' * bool(name)} ({scan.words}, {places})", scan) for name, scan in maps.items()
    ]
    drawn = drawn or [("curves in their order", None)] * (not alone)
    stem = Path(f"{targets.stem}-{'map' if maps else 'curves'}")
    stems = [stem] if {*maps} <= {""} else beside(stem, [*maps])
    of_maps = [(words, partial(_map_figure, scan, result.outcomes), output.files(one, PICTURES, request.inputs))
               for (words, scan), one in zip(drawn * output.plots, stems, strict=False)]  # fmt: skip
    several = output.plots and len(result.outcomes) > 1
    of_curves = output.files(Path(f"{targets.stem}-curves"), (".html",) if several else (), request.inputs)
    with together():
        lines = [files.json_line(one) for one in summary["curves"]]
        targets.write(result.columns, summary, lines=lines)
        archive.write_fits(targets[".h5"], result.outcomes, result.body, lines, maps)
        count = _draw(pictures, left) if pictures else 0
        if result.samples and request.samples:
            request.samples.write(result.samples.columns)
            if output.plots:
                _picture("the picture of the samples", request.samples, result.samples.figure, left)
        if several:
            from .curve_page import page

            words = partial(page, result.outcomes, f"fit to {request.body_words}")
            if text := attempted("the page of all curves", words, "", left):
                write_text(of_curves[".html"], text)
            several = bool(text)
        of_maps = [one for one in of_maps if _picture(one[0], one[2], one[1], left)]
        figures: dict[str, Callable[[], Any]] = {words: figure for words, figure, _ in of_maps}
        if len(result.outcomes) == 1 and result.fits and output.plots:
            figures = {"the fitted curve": result.fits[0].figure}
    beside_it = {targets[".csv"]: "E*, w and their errors of each curve", targets[".json"]: "all of it, by curve",
                 targets[".h5"]: "readings and fitted curves"}  # fmt: skip
    if result.samples and request.samples:
        beside_it |= {request.samples[".csv"]: "the samples"}
        beside_it |= {request.samples[".png"]: "E*, w of each sample"} if output.plots else {}
    beside_it |= {of_curves[".html"]: "a page to click through all curves"} if several else {}
    beside_it |= {one[".png"]: words for words, _, one in of_maps}
    if request.report is not None:
        pairs = zip(request.measured, request.options.tip_radius, strict=False)
        radii = [f"{path.name} {show(radius, 'length')}" for path, radius in pairs]  # of each file or folder
        of_inputs = [*calibration, *[f"Tip radius: {', '.join(radii)}."] * (len(radii) > 1)]
        of_inputs += [f"Standard uncertainty of {name}: {size}." for name, size in request.options.uncertain]
        _report(request, result, figures, beside_it, of_inputs)
    if not result.fits:
        raise InputError(some(reasons))
    where = [f"samples in {request.samples}"] * bool(result.samples and request.samples)
    where += [f"all curves in {of_curves}"] * several + [f"{words} in {one}" for words, _, one in of_maps]
    where += [f"report in {request.report}"] * bool(request.report)
    return count, "".join(f", {one}" for one in where)


def _map_figure(scan: Any, outcomes: Sequence[Outcome]) -> Any:
    """The images of a map, or, where there is none, the curves in their order."""
    from .figures import curves_figure, map_figure

    return curves_figure(outcomes) if scan is None else map_figure(scan)


def _report(
    request: FitRequest, result: Fits, figures: dict[str, Callable[[], Any]], beside_it: dict[Path, str],
    calibration: Sequence[str],
) -> None:  # fmt: skip
    """Write the report as a page and as Markdown."""
    assert request.report is not None
    page = next((path.name for path in beside_it if path.suffix == ".html"), "")
    inputs = [one for path in dict.fromkeys([*request.inputs, *request.measured]) for one in
              (measured.files_in(path) if path.is_dir() else [path])]  # fmt: skip
    if result.samples and request.output.plots:
        each = {
            f"{SYMBOLS.get(name, name)} by sample": partial(result.samples.figure, name)
            for name in result.samples.quantities
        }
        figures = each | figures
    specimen = _specimen(request.body) + (f", from {result.body}" if result.body.endswith((".toml", ".h5")) else "")
    report = offered("report of a fit")(
        result.columns, result.samples, specimen, calibration, result.warnings, figures, inputs,
        command_line(), {path.name: holds for path, holds in beside_it.items()}, page,
    )  # fmt: skip
    write_text(request.report[".html"], report.as_html())
    write_text(request.report[".md"], report.as_markdown())


def _pictures(request: FitRequest, each: list[list[Outcome]], bodies: list[FittedBody]) -> Pictures:
    """Curves to draw, fitted or not, each with its files, named after its file, itself where it is not alone, and, of
    several, the surface; none where they are many."""
    named: list[tuple[Outcome, str]] = []
    for items, body in zip(each, bodies, strict=True):
        shown = [item for item in items if isinstance(item, Fit)
                 or (item.curve is not None and {"delta", "P"} <= set(item.curve.measured))]  # fmt: skip
        for item in shown if len(shown) <= SHOWN else []:
            surface = [body.problem.surface] * (len(bodies) > 1)
            words = [Path(item.file).stem, *[item.name] * (len(shown) > 1), *surface]
            named.append((item, "-".join(words)))
    stems = beside(request.targets.stem, [name for _, name in named])
    return [(item, request.output.files(stem, PICTURES, request.inputs))
            for (item, _), stem in zip(named, stems, strict=True)]  # fmt: skip


def _draw(drawn: Pictures, left: list[str]) -> int:
    """The fitted curve over its data; of a curve that could not be fitted its record, if it can be taken apart. How
    many are drawn."""
    from .figures import fit_figure, record_figure

    count = 0
    for item, target in drawn:
        what = f"the picture of {item.where}"
        if isinstance(item, Fit):
            count += _picture(what, target, partial(fit_figure, item), left)
            continue
        with contextlib.suppress(InputError):
            assert item.curve is not None
            count += _picture(what, target, partial(record_figure, [segment_force_curve(item.curve)]), left)
    return count


def _picture(what: str, target: Files, figure: Callable[[], Any], left: list[str]) -> bool:
    """Whether a picture could be drawn and written, which else is left out; files that cannot be written are refused as
    those of results are."""
    if (made := attempted(what, figure, None, left)) is None:
        return False
    try:
        target.write(figure=made)
    except (JkrError, OSError):
        raise
    except Exception as error:
        left.append(left_out(what, error))
        return False
    return True


SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
HOW = ("segment", "base_line", "branch", "loss", "confidence", "model", "level", "samples", "seed")
NO_RANGE = "has no adhesion of finite range: leave the case's adhesion.range, stress and capillary out"


def fit_measured(
    body: Path, measured: tuple[Path, ...], flags: Flags, reading: Reading, slopes: str, parallel: Parallel,
    limits: Limits, output: Output, asked: FitOptions,
) -> None:  # fmt: skip
    """What was ``asked`` of a fit of the ``measured`` files to a ``body``, a file or the flags."""
    source, given = body_and_measured(body, measured, flags)
    paths = tuple(one for path in given for one in folders_of(path))
    inputs = (body, *given) if isinstance(source, Path) else given
    # The kind of fit by its options; that of a surface tension shows in the parameters.
    if asked.relaxation is None and "relaxation" in _flat(asked.free):
        raise InputError(f"fit: the law is not named: give --relaxation {', '.join(RELAXATIONS)}")
    kinds = {RELAXATION: asked.relaxation, LAW: asked.law, SHARED: asked.shared}
    typed, kind = options.typed_options(), next((kind for kind, value in kinds.items() if value), EACH)
    if kind != EACH:
        check_unused(kind, typed, flag)
    # What is written, but for pictures of curves, whose names are known when they are read: named after the case, the
    # one map or the one file, after none of several files.
    timed = kind != EACH
    endings = (".csv", ".json", *PICTURES) if timed else (".csv", ".json", ".h5")
    named = given[0] if len(given) == 1 and (holds_map(given[0]) or body in given) else body
    folder = output.folder(body.parent if len({path.parent for path in inputs}) == 1 else Path())
    named = named if named.name else named.absolute()  # "."
    prefix = "" if len(given) > 1 and body in given else f"{named.name if named.is_dir() else named.stem}-"
    targets = output.files(folder / f"{prefix}fit", endings, inputs)
    refuse_another_selection(targets, inputs, output.force)
    of_samples = None
    if not timed and is_offered("samples of a fit") and sample_names(paths, asked.sample) is not None:
        of_samples = output.files(folder / f"{prefix}samples", (".csv", ".png"), inputs)
    of_report = output.files(folder / f"{prefix}report", (".html", ".md"), inputs) if asked.report else None
    for longest in [] if timed else beside(targets.stem, ["x" * files.SHORTEST]):
        output.files(longest, PICTURES, inputs)
    refits = refits_of(asked.confidence, asked.samples, len(asked.uncertain))
    surfaces = SURFACES.get(asked.surface or "", ("",))
    per_row, per_file = TABLE_FIT_PER_ROW + refits * TABLE_REFIT_PER_ROW, refits * TABLE_REFIT
    begin_reading("fit", paths, limits, FEWER, per_row=len(surfaces) * per_row, per_file=len(surfaces) * per_file)
    fitted = fitted_body(source, slopes, limits)
    adheres = bool(asked.law) or "w" in _flat(asked.free) or "w" in dict(asked.fix)
    if fitted.range_of_case and (kind == LAW or (kind == RELAXATION and not adheres)):
        raise InputError(f"fit: {kind} {NO_RANGE}")
    words = str(source) if isinstance(source, Path) else _specimen(fitted)
    # The parameters that are free beside the usual ones, those that records share or have each among them.
    known = (*USUALLY_FREE, ALIAS, *dict(asked.fix))
    own = [name for name in _flat((*asked.shared, *asked.own)) if name not in known]
    request = FitRequest(
        fitted, paths, reading, [*_flat(asked.free), *own], asked, targets, words, output, inputs, of_samples, of_report
    )
    if kind in (EACH, SHARED):
        kind = TENSION if has_tension(request) else kind
        check_unused(kind, typed, flag)
        request = replace(request, reading=replace(reading, contact="as-is"))  # the fit finds zeros with the rest
    if kind == RELAXATION:
        offered("fit of a law of relaxation")(request)
    elif kind == LAW:
        offered("fit of a law over speed")(request)
    elif kind == TENSION:
        fit_tension(replace(request, targets=output.files(targets.stem, (".csv", ".json"), inputs)))
    elif kind == SHARED:
        fit_joint(request, _settings(request, reading.contact))
    else:
        bodies = [fitted.on_surface(one) for one in SURFACES[asked.surface or fitted.problem.surface]]
        fit_curves(request, bodies, _settings(request, reading.contact), refits, limits, parallel)


def _specimen(body: FittedBody) -> str:
    """The specimen from options in words, but for what stands for a modulus and a depth that were not given."""
    words = body.problem.words.partition(" to a contact radius of ")[0]
    return words if body.moduli_known else words.replace(f"E = {NO_MODULUS}, ", "")


def _settings(request: FitRequest, contact: str) -> Settings:
    """The settings of a fit from its request: free parameters, data, method."""
    asked = request.options
    how = {name: getattr(asked, name) for name in HOW} | {"noise": dict(asked.noise), "contact": contact}
    return settings_of(request.body, request.names, asked.fix, asked.start, asked.bound, asked.uncertain, **how)


def _flat(groups: Iterable[Sequence[str]]) -> list[str]:
    return [name for group in groups for name in group]
