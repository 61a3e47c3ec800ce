"""``jkr fit``: E*, w and the zero points from measured curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..adhesion import RATE_LAWS
from ..base import InputError
from ..base.files import TUNING as FILES
from ..base.files import beside
from ..bodies import RELAXATIONS
from ..methods.guards import Limits
from ..report.output import PICTURES, SHOWN, Files, Output
from .body import FLAGS, body_options, given_flags, tables_of
from .fit_curves import FEWER, fit_curves, refits_of
from .fit_idle import EACH, LAW, RELAXATION, SHARED, TENSION, given, refuse_idle
from .fit_joint import fit_joint
from .fit_law import Asked, fit_law
from .fit_relaxation import fit_relaxation
from .fit_tension import fit_tension, is_asked
from .measured import TUNING, begin_reading, reading_of, reading_options
from .options import (
    NamedType,
    ParamType,
    RangeType,
    ScaleType,
    limits_options,
    parallel_options,
    slopes_option,
)
from .output import into_folder, output_options
from .verb import Verb

if TYPE_CHECKING:
    from ..identification.fit import Fit, FittedBody, Settings
    from ..identification.fit.fitting import Failure

    Pictures = list[tuple[Fit | Failure, Files]]

SHALLOW = 0.2  # choice: of the tip radius, to which a body by flags is solved first; the data may ask for more
POINTED = 5e-6  # choice: [m], in place of the radius of a tip that has none
SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
NO_RANGE = "has no adhesion of finite range: leave the case's adhesion.range, stress and capillary out"


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
    help="Also free: P0, compliance, E:LAYER, h:LAYER (thickness), range or stress (of adhesion), drift, "
    "surface_tension.",
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
              help="Of a raw record; sine: with optical interference.")  # fmt: skip
@click.option("--branch", type=click.Choice(["all", "compressive"]), default="all", show_default=True,
              help="compressive: rows under compression only.")  # fmt: skip
@click.option("--noise", multiple=True, type=ScaleType(),
              help='Standard deviation of the readings, P="2 nN" [default: from the record].')  # fmt: skip
@click.option("--loss", type=click.Choice(["linear", "soft_l1", "huber", "cauchy"]), default="linear",
              show_default=True, help="Anything but linear is robust against outliers.")  # fmt: skip
@click.option("--confidence", type=click.Choice(["covariance", "profile", "bootstrap"]), default="covariance",
              show_default=True, help="How the intervals are found.")  # fmt: skip
@click.option("--model", type=click.Choice(["jkr", "auto"]), default="jkr", show_default=True,
              help="Of a raw record; auto: the best other models too, where its data ask for one.")  # fmt: skip
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
    jkr fit coating.toml probe.csv --free E:skin --bound E:skin="1 MPa..1 GPa"
    jkr fit gel.toml small.csv large.csv --free surface_tension \\
            --tip-radius "5 um" --tip-radius "30 um"
    jkr fit gel.toml held.csv --relaxation sls
    jkr fit gel.toml small.csv large.csv --shared E_star,w
    """
    flags = {key: options.pop(key) for key in FLAGS}
    source, paths = _given(body_file, measured, flags)
    inputs = (body_file, *measured)
    common, kept = ([name for group in groups for name in group] for groups in (shared, own))
    names = [*(name for group in free for name in group), *_freed((*common, *kept), fix)]
    if relaxation is None and "relaxation" in names:
        raise InputError(f"fit: the law is not named: give --relaxation {', '.join(RELAXATIONS)}")
    kind = RELAXATION if relaxation else LAW if law else SHARED if common else EACH
    if kind != EACH:
        refuse_idle(kind, given())
    targets = _targets(body_file, kind != EACH, inputs, output)
    refits = refits_of(options["confidence"], options["samples"], len(uncertain))
    surfaces = len(SURFACES.get(surface or "", ("",)))
    per_row, per_file = TUNING.fit_per_row + refits * TUNING.refit_per_row, refits * TUNING.refit
    begin_reading("fit", paths, limits, FEWER, per_row=surfaces * per_row, per_file=surfaces * per_file)
    reading = reading_of(options)
    options["noise"], options["contact"] = dict(options["noise"]), reading.contact
    body = _body(source, slopes, limits)
    told = str(source) if isinstance(source, Path) else body.problem.words
    if (law or relaxation) and body.asked:
        raise InputError(f"fit: --{'law' if law else 'relaxation'} {NO_RANGE}")
    options |= {"rivals": rivals, "plan": plan}
    asked = Asked(body, paths, reading, names, fix, start, dict(options), targets, told, output)
    if kind in (EACH, SHARED):
        kind = TENSION if is_asked(body, names, fix) else kind
        refuse_idle(kind, given())
    if relaxation is not None:
        fit_relaxation(asked, relaxation)
    elif kind == TENSION:
        fit_tension(replace(asked, targets=output.files(targets.stem, (".csv", ".json"), inputs)), tip_radius)
    elif law is not None:
        fit_law(asked, law)
    else:
        for name in ("terms", "rivals", "plan"):
            del options[name]
        asked = replace(asked, reading=replace(reading, contact="as-is"))
        settings = _settings(body, uncertain, names, fix, start, bound, options)
        if common:
            fit_joint(asked, tip_radius, settings, common, kept)
            return
        bodies = [body.on_surface(one) for one in SURFACES[surface or body.problem.surface]]
        fit_curves(asked, bodies, settings, refits, inputs, limits, workers, scheduler)


def _targets(body_file: Path, timed: bool, inputs: tuple[Path, ...], output: Output) -> Files:
    """What is written, but for pictures of curves, whose names are known when they are read."""
    endings = (".csv", ".json", *PICTURES) if timed else (".csv", ".json", ".h5")
    targets = output.files(output.folder(body_file.parent) / f"{body_file.stem}-fit", endings, inputs)
    for longest in [] if timed else beside(targets.stem, ["x" * FILES.shortest]):
        output.files(longest, PICTURES, inputs)
    return targets


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
