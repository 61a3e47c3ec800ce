"""``jkr fit``: E*, w and the zero points from measured curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..base import InputError, beside
from ..base.files import TUNING as FILES
from ..bodies import RELAXATIONS
from ..methods import Limits
from ..report import PICTURES, Files, Output
from .body import FLAGS, fitted_body, given_body
from .fit_curves import FEWER, fit_curves, refits_of
from .fit_idle import EACH, LAW, RELAXATION, SHARED, TENSION, given, refuse_idle
from .fit_options import fit_options
from .fit_relaxation import fit_relaxation
from .fit_together import Asked, fit_joint, fit_law, fit_tension, is_asked
from .measured import TUNING, begin_reading, reading_of
from .verb import Verb

if TYPE_CHECKING:
    from ..identification.fit import FittedBody, Settings

SURFACES = {"both": ("sliding", "sticking"), "sliding": ("sliding",), "sticking": ("sticking",)}
NO_RANGE = "has no adhesion of finite range: leave the case's adhesion.range, stress and capillary out"


@click.command(cls=Verb)
@click.argument("body_file", metavar="BODY", type=click.Path(path_type=Path))
@click.argument("measured", nargs=-1, type=click.Path(path_type=Path))
@fit_options
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
    source, paths = given_body(body_file, measured, flags)
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
    body = fitted_body(source, slopes, limits)
    told = str(source) if isinstance(source, Path) else body.problem.words
    if (law or relaxation) and body.asked:
        raise InputError(f"fit: --{'law' if law else 'relaxation'} {NO_RANGE}")
    options |= {"rivals": rivals, "plan": plan}
    asked = Asked(body, paths, reading, names, fix, start, dict(options), targets, told, output)
    if kind in (EACH, SHARED):
        kind = TENSION if is_asked(body, names, fix) else kind
        refuse_idle(kind, given())
        asked = replace(asked, reading=replace(reading, contact="as-is"))  # the fit finds zeros with the rest
    if relaxation is not None:
        fit_relaxation(asked, relaxation)
    elif kind == TENSION:
        fit_tension(replace(asked, targets=output.files(targets.stem, (".csv", ".json"), inputs)), tip_radius)
    elif law is not None:
        fit_law(asked, law)
    else:
        for name in ("terms", "rivals", "plan"):
            del options[name]
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
    from ..identification.fit import ALIAS, USUALLY_FREE

    return [name for name in names if name not in (*USUALLY_FREE, ALIAS, *dict(fix))]


def _settings(
    body: FittedBody, uncertain: tuple[tuple[str, str], ...], names: list[str], fix: Any, start: Any, bound: Any,
    options: dict[str, Any],
) -> Settings:  # fmt: skip
    """What is fitted and how; uncertain inputs are known only when the parameters are."""
    from ..identification.fit import settings_of, uncertain_of

    settings = settings_of(body, names, fix, start, bound, **options)
    if not uncertain:
        return settings
    carried = uncertain_of(body, uncertain, settings)
    return settings_of(body, names, fix, start, bound, uncertain=carried, **options)
