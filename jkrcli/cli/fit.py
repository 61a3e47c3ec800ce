"""``jkr fit``: E*, w and the zero points from measured curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base import InputError, beside
from ..base.files import TUNING as FILES
from ..bodies import RELAXATIONS
from ..data import Reading
from ..methods import Limits
from ..report import PICTURES, Files, Output
from .body import fitted_body, given_body
from .fit_curves import FEWER, fit_curves, refits_of
from .fit_idle import EACH, LAW, RELAXATION, SHARED, TENSION, given, refuse_idle
from .fit_options import fit_options
from .fit_relaxation import fit_relaxation
from .fit_together import Asked, fit_joint, fit_law, fit_tension, is_asked
from .measured import TUNING, begin_reading
from .verb import Verb

if TYPE_CHECKING:
    from ..identification.fit import Settings

SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
HOW = ("segment", "base_line", "branch", "loss", "confidence", "model", "level", "samples", "seed")
NO_RANGE = "has no adhesion of finite range: leave the case's adhesion.range, stress and capillary out"


@click.command(cls=Verb)
@click.argument("body_file", metavar="BODY", type=click.Path(path_type=Path))
@click.argument("measured", nargs=-1, type=click.Path(path_type=Path))
@fit_options
def fit(
    body_file: Path,
    measured: tuple[Path, ...],
    flags: dict[str, str | None],
    reading: Reading,
    slopes: str,
    parallel: tuple[int | None, str | None],
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
    source, paths = given_body(body_file, measured, flags)
    inputs = (body_file, *measured)
    told, kind = given(), _kind(options)
    if kind != EACH:
        refuse_idle(kind, told)
    targets = _targets(body_file, kind != EACH, inputs, output)
    refits = refits_of(options["confidence"], options["samples"], len(options["uncertain"]))
    surfaces = SURFACES.get(options["surface"], ("",))
    per_row, per_file = TUNING.fit_per_row + refits * TUNING.refit_per_row, refits * TUNING.refit
    begin_reading("fit", paths, limits, FEWER, per_row=len(surfaces) * per_row, per_file=len(surfaces) * per_file)
    body = fitted_body(source, slopes, limits)
    if kind in (LAW, RELAXATION) and body.asked:
        raise InputError(f"fit: {kind} {NO_RANGE}")
    words = str(source) if isinstance(source, Path) else body.problem.words
    asked = Asked(body, paths, reading, _names(options), options, targets, words, output)
    if kind in (EACH, SHARED):
        kind = TENSION if is_asked(asked) else kind
        refuse_idle(kind, told)
        asked = replace(asked, reading=replace(reading, contact="as-is"))  # the fit finds zeros with the rest
    if kind == RELAXATION:
        fit_relaxation(asked)
    elif kind == LAW:
        fit_law(asked)
    elif kind == TENSION:
        fit_tension(replace(asked, targets=output.files(targets.stem, (".csv", ".json"), inputs)))
    elif kind == SHARED:
        fit_joint(asked, _settings(asked, reading.contact))
    else:
        bodies = [body.on_surface(one) for one in SURFACES[options["surface"] or body.problem.surface]]
        fit_curves(asked, bodies, _settings(asked, reading.contact), refits, inputs, limits, parallel)


def _kind(options: Mapping[str, Any]) -> str:
    """Which kind of fit is asked for, but for that of a surface tension."""
    if options["relaxation"] is None and "relaxation" in _flat(options["free"]):
        raise InputError(f"fit: the law is not named: give --relaxation {', '.join(RELAXATIONS)}")
    kinds = {RELAXATION: options["relaxation"], LAW: options["law"], SHARED: options["shared"]}
    return next((kind for kind, given in kinds.items() if given), EACH)


def _names(options: Mapping[str, Any]) -> list[str]:
    """The parameters that are free beside the usual ones, those that records share or have each among them."""
    from ..identification.fit import ALIAS, USUALLY_FREE

    kept = (*USUALLY_FREE, ALIAS, *dict(options["fix"]))
    own = [name for name in _flat((*options["shared"], *options["own"])) if name not in kept]
    return [*_flat(options["free"]), *own]


def _targets(body_file: Path, timed: bool, inputs: tuple[Path, ...], output: Output) -> Files:
    """What is written, but for pictures of curves, whose names are known when they are read."""
    endings = (".csv", ".json", *PICTURES) if timed else (".csv", ".json", ".h5")
    targets = output.files(output.folder(body_file.parent) / f"{body_file.stem}-fit", endings, inputs)
    for longest in [] if timed else beside(targets.stem, ["x" * FILES.letters[0]]):
        output.files(longest, PICTURES, inputs)
    return targets


def _settings(asked: Asked, contact: str) -> Settings:
    """What is fitted and how; uncertain inputs are known only when the parameters are."""
    from ..identification.fit import settings_of, uncertain_of

    options = asked.options
    told = (asked.body, asked.names, options["fix"], options["start"], options["bound"])
    how = {name: options[name] for name in HOW} | {"noise": dict(options["noise"]), "contact": contact}
    settings = settings_of(*told, **how)
    if not options["uncertain"]:
        return settings
    return settings_of(*told, uncertain=uncertain_of(asked.body, options["uncertain"], settings), **how)


def _flat(groups: Iterable[Sequence[str]]) -> list[str]:
    return [name for group in groups for name in group]
