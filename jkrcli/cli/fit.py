"""``jkr fit``: E*, w and the zero points from measured curves."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..adhesion.rate.laws import RATE_LAWS
from ..base.errors import InputError
from ..base.files import TUNING as FILES
from ..base.files import beside, together
from ..bodies.relaxation import RELAXATIONS
from ..methods import Forecast
from ..methods.guards import Limits
from ..report.output import PICTURES, Files, Output
from .body import FLAGS, body_options, given_flags, tables_of
from .fit_idle import EACH, LAW, RELAXATION, SHARED, TENSION, given, refuse_idle
from .fit_joint import fit_joint
from .fit_law import fit_law
from .fit_relaxation import fit_relaxation
from .fit_tension import fit_tension, is_asked
from .measured import TUNING, begin_reading, reading_of, reading_options
from .options import (
    NamedType,
    ParamType,
    RangeType,
    ScaleType,
    begin,
    limits_options,
    parallel_options,
    slopes_option,
)
from .output import answer, into_folder, output_options
from .verb import Verb
from .voice import note, present, progress, say, warn

if TYPE_CHECKING:
    from ..identification.fit import Fit, FittedBody, Settings
    from ..identification.fit.fitting import Failure

    Pictures = list[tuple[Fit | Failure, Files]]

SHALLOW = 0.2  # choice: of the tip radius, to which a body by flags is solved first; the data may ask for more
POINTED = 5e-6  # choice: [m], in place of the radius of a tip that has none
FEWER = "fewer rows, curves or samples"
SHOWN = 10  # curves that are told line by line, and drawn
SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
NO_RANGE = "knows no adhesion of finite range, which the case asks for: leave adhesion.range, stress and capillary out"


class NamesType(ParamType):
    """One or several names, separated by commas."""

    name = "NAME,..."

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        return (
            value if isinstance(value, tuple) else tuple(part.strip() for part in str(value).split(",") if part.strip())
        )


@click.command(cls=Verb)
@click.argument("body_file", metavar="BODY", type=click.Path(path_type=Path))
@click.argument("measured", nargs=-1, type=click.Path(path_type=Path))
@body_options
@click.option(
    "--free",
    multiple=True,
    type=NamesType(),
    help="Also free: P0, compliance, E:LAYER, h:LAYER (thickness), range or stress (adhesion of finite range), drift "
    "(of the depth over time), surface_tension (all records together).",
)
@click.option(
    "--fix", multiple=True, type=NamedType(), help='Known: w="50 mJ/m^2", delta0=0, modulus=1, E_star="1 MPa".'
)
@click.option("--start", multiple=True, type=NamedType(), help="Starting value, beside those found in the data.")
@click.option("--bound", multiple=True, type=NamedType(), help='Bounds, w="10 mJ/m^2..1 J/m^2"; one may be left out. '
              'Of a range that is not fitted what is known: range="..10 nm".')  # fmt: skip
@click.option(
    "--law",
    type=click.Choice(list(RATE_LAWS)),
    help="Adhesion depends on the speed of the edge: w0 and "
    "the law's v0, n (or v0, b) are free too, all records are fitted together; needs t, delta, P.",
)
@click.option("--relaxation", type=click.Choice(list(RELAXATIONS)), help="The body relaxes: its modulus, the law's "
              "parameters and delta0 from t, delta, P of pressing, waiting and retracting, no adhesion.")  # fmt: skip
@click.option("--terms", type=click.IntRange(1, 4), help="Of --relaxation prony [default: 2].")
@click.option("--segment", type=click.Choice(["approach", "retract", "both"]),
              help="Rows to fit [default: retract where the file names segments, else all].")  # fmt: skip
@click.option("--base-line", type=click.Choice(["straight", "sine"]), default="straight", show_default=True,
              help="Of a raw record; sine: on top of it the wave of light that interferes.")  # fmt: skip
@click.option("--branch", type=click.Choice(["all", "compressive"]), default="all", show_default=True,
              help="compressive: rows under compression only.")  # fmt: skip
@click.option("--noise", multiple=True, type=ScaleType(),
              help='Standard deviation of the readings, P="2 nN" [default: from the record].')  # fmt: skip
@click.option("--loss", type=click.Choice(["linear", "soft_l1", "huber", "cauchy"]), default="linear",
              show_default=True, help="Anything but linear is robust against outliers.")  # fmt: skip
@click.option("--confidence", type=click.Choice(["covariance", "profile", "bootstrap"]), default="covariance",
              show_default=True, help="How the intervals are found.")  # fmt: skip
@click.option("--rivals", is_flag=True, help="Print what the data of a raw record say of each other model.")
@click.option("--plan", is_flag=True, help="Print which further measurement would narrow E* and w most.")
@click.option("--level", type=float, default=0.95, show_default=True, help="Of the intervals.")
@click.option(
    "--samples", type=click.IntRange(20, 100_000), default=200, show_default=True, help="Number of bootstrap resamples."
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the resamples.")
@click.option("--shared", multiple=True, type=NamesType(),
              help="Fit all records together: parameters that they share, E_star,w.")  # fmt: skip
@click.option("--own", multiple=True, type=NamesType(),
              help="With --shared: those of each record, delta0,P0 [default: all other free ones].")  # fmt: skip
@click.option(
    "--tip-radius",
    multiple=True,
    type=RangeType(),
    help="With --shared or surface_tension: of each file, or of all [default: BODY's].",
)
@click.option("--surface", type=click.Choice(["sliding", "sticking", "both"]),
              help="Of the body, instead of its own; both: under either, and what the data prefer.")  # fmt: skip
@click.option("--uncertain", multiple=True, type=NamedType(),
              help="Standard deviation of an input, carried on: radius=3%, stiffness=10%, thickness=5%.")  # fmt: skip
@slopes_option
@reading_options
@limits_options
@parallel_options
@into_folder("Folder [default: BODY's].")
@output_options(plots=f"Draw nothing (else up to {SHOWN} curves are drawn).", json="Print the summary as JSON.")
def fit(
    body_file: Path,
    measured: tuple[Path, ...],
    free: tuple[tuple[str, ...], ...],
    fix: tuple[tuple[str, str], ...],
    start: tuple[tuple[str, str], ...],
    bound: tuple[tuple[str, str], ...],
    uncertain: tuple[tuple[str, str], ...],
    surface: str | None,
    shared: tuple[tuple[str, ...], ...],
    own: tuple[tuple[str, ...], ...],
    tip_radius: tuple[float, ...],
    slopes: str,
    law: str | None,
    rivals: bool,
    plan: bool,
    relaxation: str | None,
    workers: int | None,
    scheduler: str | None,
    limits: Limits,
    output: Output,
    **options: Any,
) -> None:
    """Find E*, w and the zero points that bring the adhesive curves of BODY nearest to each MEASURED curve.

    BODY: a case or series file; or the body by flags (--radius, --nu, --thickness ...: its modulus is not needed), then
    every file is a measured one. Measured are two or three of a, delta, P. Free are the common factor of all moduli
    (E*), w and delta0, or a layer's own E:LAYER, h:LAYER (its name, its number from 1 at the contact, or base). A
    reading is delta0 + delta + compliance P, and P0 + P; orthogonal distances are minimised, in units of the noise.
    Writes <BODY>-fit.csv (a row per curve), .json, .h5 and a picture per curve; of a scan its map.

    \b
    jkr fit curve.jpk-force --radius "5 um" --nu 0.5
    jkr fit sphere.toml probe.csv --unit P=mN --uncertain nu=0.005
    jkr fit tip.toml curve.csv --free range
    jkr fit coating.toml probe.csv --free E:skin --bound E:skin="1 MPa..1 GPa"
    jkr fit gel.toml probe.csv --surface both
    jkr fit gel.toml small.csv large.csv --free surface_tension \\
            --tip-radius "5 um" --tip-radius "30 um"
    jkr fit gel.toml held.csv --relaxation sls
    jkr fit gel.toml small.csv large.csv --shared E_star,w \\
            --tip-radius "5 um" --tip-radius "30 um"
    """
    flags = {key: options.pop(key) for key in FLAGS}
    source, paths = _given(body_file, measured, flags)
    inputs = (body_file, *measured)
    common, kept = ([name for group in groups for name in group] for groups in (shared, own))
    names = [*(name for group in free for name in group), *_freed((*common, *kept), fix)]
    if relaxation is None and "relaxation" in names:
        raise InputError(f"fit: the law is not named: give --relaxation {', '.join(RELAXATIONS)}")
    kind = RELAXATION if relaxation else LAW if law else SHARED if common else EACH
    timed = kind != EACH
    if timed:
        refuse_idle(kind, given())
    endings = (".csv", ".json", ".h5") if not timed else (".csv", ".json", *PICTURES)
    targets = output.files(output.folder(body_file.parent) / f"{body_file.stem}-fit", endings, inputs)
    for longest in beside(targets.stem, ["x" * FILES.shortest]) if not timed else []:
        output.files(longest, PICTURES, inputs)
    refits = _refits(options["confidence"], options["samples"], len(uncertain))
    surfaces = len(SURFACES.get(surface or "", ("",)))
    per_row, per_file = TUNING.fit_per_row + refits * TUNING.refit_per_row, refits * TUNING.refit
    begin_reading("fit", paths, limits, FEWER, per_row=surfaces * per_row, per_file=surfaces * per_file)
    reading = reading_of(options)
    options["noise"], options["contact"] = dict(options["noise"]), reading.contact
    body = _body(source, slopes, limits)
    told = str(source) if isinstance(source, Path) else body.problem.words
    if (law or relaxation) and body.asked:
        raise InputError(f"fit: --{'law' if law else 'relaxation'} {NO_RANGE}")
    if relaxation is not None:
        fit_relaxation(body, relaxation, paths, reading, names, fix, options, targets, told, output)
        return
    options.pop("terms")
    if kind in (EACH, SHARED) and is_asked(body, names, fix):
        refuse_idle(TENSION, given())
        targets = output.files(targets.stem, (".csv", ".json"), inputs)
        fit_tension(body, paths, tip_radius, reading, names, fix, options["level"], targets, told, output)
        return
    if not timed:
        refuse_idle(EACH, given())
    if law is not None:
        fit_law(body, law, paths, reading, names, fix, start, options, targets, told, output)
        return
    settings, reading = _settings(body, uncertain, names, fix, start, bound, options), replace(reading, contact="as-is")
    if common:
        fit_joint(body, paths, tip_radius, reading, settings, common, kept, targets, told, output)
        return
    from ..base.executors import executor
    from ..data.measured import usable
    from ..identification.fit import Fit
    from ..identification.fit.fitting import Failure, fit_all

    bodies = [body.on_surface(one) for one in SURFACES[surface or body.problem.surface]]
    curves, reasons = usable(paths, reading)
    seconds = sum(
        TUNING.fit_per_curve + refits * (TUNING.refit + TUNING.refit_per_row * len(curve)) for curve in curves
    )
    begin(f"fit of {len(curves):,} curves", Forecast(surfaces * seconds, 0.0, 0.0), limits, FEWER)
    each = []
    for one in bodies:
        with executor(workers, scheduler, progress, seconds) as pool:
            each.append(fit_all(one, curves, settings, pool))
    found = [item for items in each for item in items]
    if rivals and not any(isinstance(item, Fit) and item.verdict for item in found):
        raise InputError("fit: --rivals is for raw records, which none of these was fitted as: leave it out")
    found = [_planned(item, bodies) for item in found] if plan else found
    reasons += [line for item in each[0] if isinstance(item, Failure) for line in item.lines]
    pictures = _pictures(each, bodies, targets, inputs, output) if output.plots else []
    map_file = _write(found, reasons, targets, pictures, told, output, inputs)
    for line in reasons:
        warn(f"skipped: {line}")
    drawn = f", {len(pictures)} picture{'s' if len(pictures) > 1 else ''}" if pictures else ""
    written = f"  written {targets}{drawn}" + (f", the map in {map_file}" if map_file else "")
    _tell(found, output.json, told, rivals, plan, written)
    _tell_surfaces(found, body, bodies, output.json)


def _freed(names: Sequence[str], fix: Sequence[tuple[str, str]]) -> list[str]:
    """Those of the parameters that records share or have each that are not free anyway."""
    from ..identification.fit.settings import ALIAS, USUALLY_FREE

    return [name for name in names if name not in (*USUALLY_FREE, ALIAS, *dict(fix))]


def _given(
    body_file: Path, measured: tuple[Path, ...], flags: dict[str, str | None]
) -> tuple[Path | dict[str, str | None], tuple[Path, ...]]:
    """What describes the body, a file or the flags, and the measured files: by flags every file is one."""
    by_case = not any(flags.values())
    if not by_case and body_file.suffix == ".toml":
        raise InputError(f"fit: give a body file or the body by flags, not both: {body_file} and {given_flags(flags)}")
    if by_case and not measured:
        raise InputError("fit: give MEASURED files behind BODY, or the body by flags: --radius, --nu")
    return (body_file, measured) if by_case else (flags, (body_file, *measured))


def _settings(
    body: FittedBody, uncertain: tuple[tuple[str, str], ...], names: list[str], fix: Any, start: Any, bound: Any,
    options: dict[str, Any],
) -> Settings:  # fmt: skip
    """What is fitted and how; uncertain inputs are known only when the parameters are."""
    from ..identification.fit.settings import settings_of, uncertain_of

    settings = settings_of(body, names, fix, start, bound, **options)
    if not uncertain:
        return settings
    carried = uncertain_of(body, uncertain, settings)
    return settings_of(body, names, fix, start, bound, uncertain=carried, **options)


def _write(
    found: list[Fit | Failure], reasons: list[str], targets: Files, pictures: Pictures, told: str, output: Output,
    inputs: tuple[Path, ...],
) -> Files | None:  # fmt: skip
    """Write table, summary, archive and pictures; the files of the map, if there is one. InputError, when all that can
    be written is, where no curve could be used."""
    from ..data.text_table import some
    from ..identification.fit.fitting import Failure
    from ..report import fit as report
    from ..report.map import map_of

    if not found:
        raise InputError(some(reasons))
    held = map_of(found) if output.plots else None
    of_map = None if held is None else output.files(Path(f"{targets.stem}-map"), PICTURES, inputs)
    with together():
        targets.write(report.columns(found), report.summary(found, told))
        report.write(targets[".h5"], found, told)
        _draw(pictures)
        if held is not None and of_map is not None:
            from ..report.plots.map import map_figure

            of_map.write(figure=map_figure(held))
    if all(isinstance(item, Failure) for item in found):
        raise InputError(some(reasons))
    return of_map


def _body(source: Path | dict[str, str | None], slopes: str, limits: Limits) -> FittedBody:
    """The body of a file, or of flags: there a modulus that is not told is 1 MPa, which no result depends on."""
    from ..case import parse_case
    from ..identification.fit.body import body_of
    from .series import read_series

    if isinstance(source, Path):
        return body_of(source if source.suffix == ".toml" else read_series(source), slopes, limits)
    import tomli_w

    tables = tables_of("fit", source, "a case or series file", {"radius": 1.0}, "1 MPa")
    radius = parse_case(tomli_w.dumps(tables).encode(), "fit").model.problem().indenter.tip_radius
    tables["loading"]["radius"] = SHALLOW * (radius or POINTED)
    tables["method"] = "closed-form" if source["thickness"] is None else "layered"  # so that no other is imported
    body = body_of(parse_case(tomli_w.dumps(tables).encode(), "fit"), slopes, limits)
    return replace(body, told=source["modulus"] is not None)


def _refits(confidence: str, samples: int, uncertain: int) -> int:
    """How often a curve is fitted anew for its intervals, and for as many ``uncertain`` inputs."""
    fits = {"covariance": 0, "profile": TUNING.profiled, "bootstrap": samples}
    return fits[confidence] + TUNING.carried * uncertain


def _planned(item: Fit | Failure, bodies: list[FittedBody]) -> Fit | Failure:
    """The fit with what further measurements would tell; a warning where nothing is known of it."""
    from ..identification.fit.fitting import Failure
    from ..identification.fit.plan import further

    if isinstance(item, Failure):
        return item
    try:
        return replace(item, plan=further(next(one for one in bodies if one.problem.surface == item.surface), item))
    except InputError as error:
        return replace(item, warnings=(*item.warnings, str(error)))


def _pictures(
    each: list[list[Fit | Failure]], bodies: list[FittedBody], targets: Files,
    inputs: tuple[Path, ...], output: Output,
) -> Pictures:  # fmt: skip
    """Curves to draw, fitted or not, each with its files, named after the curve and, of several, the surface."""
    named = [
        (item, name if len(bodies) == 1 else f"{name}-{body.problem.surface}")
        for items, body in zip(each, bodies, strict=True)
        for item, name in _named(items)
    ]
    stems = beside(targets.stem, [name for _, name in named])
    return [(item, output.files(stem, PICTURES, inputs)) for (item, _), stem in zip(named, stems, strict=True)]


def _named(found: list[Fit | Failure]) -> list[tuple[Fit | Failure, str]]:
    """Curves that can be drawn, each with what its pictures are called after; none where they are many."""
    from ..identification.fit.fitting import Failure

    drawable = [
        item for item in found if not (isinstance(item, Failure) and (item.curve.delta is None or item.curve.P is None))
    ]
    if len(drawable) > SHOWN:
        return []
    held = [(str(item.curve.origin or ""), item.curve.name) if isinstance(item, Failure) else (item.file, item.name)
            for item in drawable]  # fmt: skip
    names = [Path(file).stem if len(held) == 1 else f"{Path(file).stem}-{name}" for file, name in held]
    return list(zip(drawable, names, strict=True))


def _draw(drawn: Pictures) -> None:
    """The fitted curve over its data; of a curve that could not be fitted its record, if it can be taken apart."""
    from ..data.record import examine
    from ..identification.fit.fitting import Failure
    from ..report.plots.fit import fit_figure
    from ..report.plots.record import record_figure

    for item, target in drawn:
        if not isinstance(item, Failure):
            target.write(figure=fit_figure(item))
            continue
        with contextlib.suppress(InputError):
            target.write(figure=record_figure([examine(item.curve)]))


def _tell(found: list[Fit | Failure], as_json: bool, body: str, rivals: bool, plan: bool, written: str) -> None:
    from ..identification.fit import Fit
    from ..report import fit as report

    fits = [item for item in found if isinstance(item, Fit)]
    if as_json:
        answer(report.summary(found, body))
    else:
        told = [report.words(item) for item in fits[:SHOWN]]
        if len(fits) > 1:
            told = [[f"{item.where}: {first}", *rest] for item, (first, *rest) in zip(fits, told, strict=False)]
        more = f" ({len(fits) - SHOWN:,} more curves)" if len(fits) > SHOWN else ""
        present(*told, last=f"{written}{more}")
        for item in fits[:SHOWN] if rivals else ():
            say("\n".join(report.rivals_table(item)))
        for item in fits[:SHOWN] if plan else ():
            say("\n".join(report.plan_table(item)))
    both = len({item.surface for item in fits}) > 1
    for item in fits[:SHOWN]:
        for warning in item.warnings:
            warn(f"{item.where}{f', {item.surface}' if both else ''}: {warning}")


def _tell_surfaces(found: list[Fit | Failure], body: FittedBody, bodies: list[FittedBody], as_json: bool) -> None:
    """What the assumption on the surfaces matters, or what the data prefer where both were fitted."""
    from ..identification.fit.friction import friction_warnings, preferences

    if len(bodies) > 1:
        for line in preferences(found):
            (note if as_json else say)(line)
        return
    for line in friction_warnings(body, found):
        warn(line)
