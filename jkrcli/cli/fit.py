"""``jkr fit``: E*, w and the zero points from measured curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ..adhesion import RATE_LAWS
from ..base import InputError, beside, files
from ..bodies import RELAXATIONS
from ..data import Reading
from ..identification import fit as fits
from ..methods import Limits
from ..report import PICTURES, SHOWN, Files, Output
from . import options
from .body import Flags, body_and_measured, body_options, fitted_body
from .fit_curves import FEWER, fit_curves, refits_of
from .fit_idle import EACH, LAW, RELAXATION, SHARED, TENSION, refuse_idle, typed_options
from .fit_together import FitRequest, fit_joint, fit_law, fit_relaxation, fit_tension, has_tension
from .measured import TUNING, begin_reading, reading_options
from .verb import several, verb

SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
HOW = ("segment", "base_line", "branch", "loss", "confidence", "model", "level", "samples", "seed")
NO_RANGE = "has no adhesion of finite range: leave the case's adhesion.range, stress and capillary out"


class NamesType(options.ParsedType):
    """One or several names, separated by commas."""

    name = "NAME,..."

    def parsed(self, text: str) -> Any:
        return tuple(part.strip() for part in text.split(",") if part.strip())


# Of the body, of the fit, of the reading, of what is written.
OPTIONS = several(
    body_options,
    click.option("--free", multiple=True, type=NamesType(),
                 help="Also free: P0, compliance, E:LAYER, h:LAYER (thickness), range or stress (of adhesion), drift, "
                 "hysteresis, creep (of a raw record's positions), surface_tension."),
    click.option("--fix", multiple=True, type=options.NAMED,
                 help='Known: w="50 mJ/m^2", delta0=0, modulus=1, E_star="1 MPa".'),
    click.option("--start", multiple=True, type=options.NAMED, help="Starting value, beside those found in the data."),
    click.option("--bound", multiple=True, type=options.NAMED,
                 help='Bounds, w="10 mJ/m^2..1 J/m^2"; one may be left out. '
                 'Of what is not fitted what is known: range="..10 nm", surface_tension="..30 mN/m".'),
    click.option("--law", type=click.Choice(list(RATE_LAWS)),
                 help="Adhesion depends on the speed of the edge: w0 and the law's v0, n (or v0, b) are free too, all "
                 "records are fitted together; needs t, delta, P."),
    click.option("--relaxation", type=click.Choice(list(RELAXATIONS)), help="The body relaxes: its modulus, the law's "
                 "parameters and delta0 from t, delta, P of pressing, waiting and retracting, no adhesion."),
    click.option("--terms", type=click.IntRange(1, 4), help="Of --relaxation prony [default: 2]."),
    click.option("--segment", type=click.Choice(["approach", "retract", "both"]),
                 help="Rows to fit [default: both, of --law retract]."),
    click.option("--base-line", type=click.Choice(["straight", "sine"]), default="straight", show_default=True,
                 help="Of a raw record; sine: with optical interference."),
    click.option("--branch", type=click.Choice(["all", "compressive"]), default="all", show_default=True,
                 help="compressive: rows under compression only."),
    click.option("--noise", multiple=True, type=options.SCALE,
                 help='Standard deviation of the readings, P="2 nN" [default: from the record].'),
    click.option("--loss", type=click.Choice(["linear", "soft_l1", "huber", "cauchy"]), default="linear",
                 show_default=True, help="Anything but linear is robust against outliers."),
    click.option("--confidence", type=click.Choice(["covariance", "profile", "bootstrap"]), default="covariance",
                 show_default=True, help="How the intervals are found."),
    click.option("--model", type=click.Choice(["jkr", "auto"]), default="jkr", show_default=True,
                 help="Of a raw record; auto: the best other models too, where its data ask for one."),
    click.option("--rivals", is_flag=True, help="Print what the data of a raw record say of each other model."),
    click.option("--plan", is_flag=True, help="Print which further measurement would narrow E* and w most."),
    click.option("--level", type=float, default=0.95, show_default=True, help="Of the intervals."),
    click.option("--samples", type=click.IntRange(20, 100_000), default=200, show_default=True,
                 help="Number of bootstrap resamples."),
    click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the resamples."),
    click.option("--shared", multiple=True, type=NamesType(),
                 help="Fit all records together: parameters that they share, E_star,w."),
    click.option("--own", multiple=True, type=NamesType(),
                 help="With --shared: those of each record, delta0,P0 [default: all other free ones]."),
    click.option("--tip-radius", multiple=True, type=options.LENGTH_ABOVE_0,
                 help="With --shared or surface_tension: of each file, or of all [default: BODY's]."),
    click.option("--surface", type=click.Choice(["sliding", "sticking", "both"]),
                 help="Of the body, instead of its own; both: under either, and what the data prefer."),
    click.option("--uncertain", multiple=True, type=options.NAMED,
                 help="Standard deviation of an input, carried on: radius=3%, stiffness=10%, thickness=5%."),
    options.slopes_option,
    reading_options,
    options.limits_options,
    options.parallel_options,
    options.into_folder("Folder [default: BODY's]."),
    options.output_options(f"Draw nothing (else up to {SHOWN} curves are drawn).", "Print the summary as JSON."),
)  # fmt: skip


@verb("body [measured...]")
@OPTIONS
def fit(
    body: Path, measured: tuple[Path, ...], flags: Flags, reading: Reading, slopes: str, parallel: options.Parallel,
    limits: Limits, output: Output, **values: Any,
) -> None:  # fmt: skip
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
    source, paths = body_and_measured(body, measured, flags)
    inputs = (body, *measured)
    typed, kind = typed_options(), _kind(values)
    if kind != EACH:
        refuse_idle(kind, typed)
    targets = _targets(body, kind != EACH, inputs, output)
    refits = refits_of(values["confidence"], values["samples"], len(values["uncertain"]))
    surfaces = SURFACES.get(values["surface"], ("",))
    per_row, per_file = TUNING.fit_per_row + refits * TUNING.refit_per_row, refits * TUNING.refit
    begin_reading("fit", paths, limits, FEWER, per_row=len(surfaces) * per_row, per_file=len(surfaces) * per_file)
    fitted = fitted_body(source, slopes, limits)
    if kind in (LAW, RELAXATION) and fitted.range_of_case:
        raise InputError(f"fit: {kind} {NO_RANGE}")
    words = str(source) if isinstance(source, Path) else fitted.problem.words
    request = FitRequest(fitted, paths, reading, _names(values), values, targets, words, output, inputs)
    if kind in (EACH, SHARED):
        kind = TENSION if has_tension(request) else kind
        refuse_idle(kind, typed)
        request = replace(request, reading=replace(reading, contact="as-is"))  # the fit finds zeros with the rest
    if kind == RELAXATION:
        fit_relaxation(request)
    elif kind == LAW:
        fit_law(request)
    elif kind == TENSION:
        fit_tension(replace(request, targets=output.files(targets.stem, (".csv", ".json"), inputs)))
    elif kind == SHARED:
        fit_joint(request, _settings(request, reading.contact))
    else:
        bodies = [fitted.on_surface(one) for one in SURFACES[values["surface"] or fitted.problem.surface]]
        fit_curves(request, bodies, _settings(request, reading.contact), refits, limits, parallel)


def _kind(values: Mapping[str, Any]) -> str:
    """The kind of fit by its options; that of a surface tension shows in the parameters."""
    if values["relaxation"] is None and "relaxation" in _flat(values["free"]):
        raise InputError(f"fit: the law is not named: give --relaxation {', '.join(RELAXATIONS)}")
    kinds = {RELAXATION: values["relaxation"], LAW: values["law"], SHARED: values["shared"]}
    return next((kind for kind, value in kinds.items() if value), EACH)


def _names(values: Mapping[str, Any]) -> list[str]:
    """The parameters that are free beside the usual ones, those that records share or have each among them."""
    known = (*fits.USUALLY_FREE, fits.ALIAS, *dict(values["fix"]))
    own = [name for name in _flat((*values["shared"], *values["own"])) if name not in known]
    return [*_flat(values["free"]), *own]


def _targets(body_file: Path, timed: bool, inputs: tuple[Path, ...], output: Output) -> Files:
    """What is written, but for pictures of curves, whose names are known when they are read."""
    endings = (".csv", ".json", *PICTURES) if timed else (".csv", ".json", ".h5")
    targets = output.files(output.folder(body_file.parent) / f"{body_file.stem}-fit", endings, inputs)
    for longest in [] if timed else beside(targets.stem, ["x" * files.TUNING.letters[0]]):
        output.files(longest, PICTURES, inputs)
    return targets


def _settings(request: FitRequest, contact: str) -> fits.Settings:
    """What is fitted and how; uncertain inputs are known only when the parameters are."""
    values = request.options
    free = (request.body, request.names, values["fix"], values["start"], values["bound"])
    how = {name: values[name] for name in HOW} | {"noise": dict(values["noise"]), "contact": contact}
    settings = fits.settings_of(*free, **how)
    if not values["uncertain"]:
        return settings
    return fits.settings_of(*free, uncertain=fits.uncertain_of(request.body, values["uncertain"], settings), **how)


def _flat(groups: Iterable[Sequence[str]]) -> list[str]:
    return [name for group in groups for name in group]
