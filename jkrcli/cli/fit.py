"""``jkr fit``: E*, w and the zero points from measured curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base import InputError, beside
from ..base.files import TUNING as FILES
from ..bodies import RELAXATIONS
from ..data import Reading
from ..methods import Limits
from ..report import PICTURES, Files, Output
from .body import Flags, body_and_measured, fitted_body
from .fit_curves import FEWER, fit_curves, refits_of
from .fit_idle import EACH, LAW, RELAXATION, SHARED, TENSION, refuse_idle, typed_options
from .fit_options import fit_options
from .fit_relaxation import fit_relaxation
from .fit_together import FitRequest, fit_joint, fit_law, fit_tension, has_tension
from .measured import TUNING, begin_reading
from .options import Parallel
from .verb import verb

if TYPE_CHECKING:
    from ..identification.fit import Settings

SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
HOW = ("segment", "base_line", "branch", "loss", "confidence", "model", "level", "samples", "seed")
NO_RANGE = "has no adhesion of finite range: leave the case's adhesion.range, stress and capillary out"


@verb("body [measured...]")
@fit_options
def fit(
    body: Path,
    measured: tuple[Path, ...],
    flags: Flags,
    reading: Reading,
    slopes: str,
    parallel: Parallel,
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
    source, paths = body_and_measured(body, measured, flags)
    inputs = (body, *measured)
    typed, kind = typed_options(), _kind(options)
    if kind != EACH:
        refuse_idle(kind, typed)
    targets = _targets(body, kind != EACH, inputs, output)
    refits = refits_of(options["confidence"], options["samples"], len(options["uncertain"]))
    surfaces = SURFACES.get(options["surface"], ("",))
    per_row, per_file = TUNING.fit_per_row + refits * TUNING.refit_per_row, refits * TUNING.refit
    begin_reading("fit", paths, limits, FEWER, per_row=len(surfaces) * per_row, per_file=len(surfaces) * per_file)
    fitted = fitted_body(source, slopes, limits)
    if kind in (LAW, RELAXATION) and fitted.range_of_case:
        raise InputError(f"fit: {kind} {NO_RANGE}")
    words = str(source) if isinstance(source, Path) else fitted.problem.words
    request = FitRequest(fitted, paths, reading, _names(options), options, targets, words, output, inputs)
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
        bodies = [fitted.on_surface(one) for one in SURFACES[options["surface"] or fitted.problem.surface]]
        fit_curves(request, bodies, _settings(request, reading.contact), refits, limits, parallel)


def _kind(options: Mapping[str, Any]) -> str:
    """The kind of fit by its options; that of a surface tension shows in the parameters."""
    if options["relaxation"] is None and "relaxation" in _flat(options["free"]):
        raise InputError(f"fit: the law is not named: give --relaxation {', '.join(RELAXATIONS)}")
    kinds = {RELAXATION: options["relaxation"], LAW: options["law"], SHARED: options["shared"]}
    return next((kind for kind, value in kinds.items() if value), EACH)


def _names(options: Mapping[str, Any]) -> list[str]:
    """The parameters that are free beside the usual ones, those that records share or have each among them."""
    from ..identification.fit import ALIAS, USUALLY_FREE

    known = (*USUALLY_FREE, ALIAS, *dict(options["fix"]))
    own = [name for name in _flat((*options["shared"], *options["own"])) if name not in known]
    return [*_flat(options["free"]), *own]


def _targets(body_file: Path, timed: bool, inputs: tuple[Path, ...], output: Output) -> Files:
    """What is written, but for pictures of curves, whose names are known when they are read."""
    endings = (".csv", ".json", *PICTURES) if timed else (".csv", ".json", ".h5")
    targets = output.files(output.folder(body_file.parent) / f"{body_file.stem}-fit", endings, inputs)
    for longest in [] if timed else beside(targets.stem, ["x" * FILES.letters[0]]):
        output.files(longest, PICTURES, inputs)
    return targets


def _settings(request: FitRequest, contact: str) -> Settings:
    """What is fitted and how; uncertain inputs are known only when the parameters are."""
    from ..identification.fit import settings_of, uncertain_of

    options = request.options
    free = (request.body, request.names, options["fix"], options["start"], options["bound"])
    how = {name: options[name] for name in HOW} | {"noise": dict(options["noise"]), "contact": contact}
    settings = settings_of(*free, **how)
    if not options["uncertain"]:
        return settings
    return settings_of(*free, uncertain=uncertain_of(request.body, options["uncertain"], settings), **how)


def _flat(groups: Iterable[Sequence[str]]) -> list[str]:
    return [name for group in groups for name in group]
