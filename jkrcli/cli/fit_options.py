"""The options of ``jkr fit``."""

from __future__ import annotations

from typing import Any

import click

from ..adhesion import RATE_LAWS
from ..bodies import RELAXATIONS
from ..report import SHOWN
from .body import body_options
from .measured import reading_options
from .option_types import LENGTH_ABOVE_0, NamedType, ParsedType, ScaleType
from .options import limits_options, parallel_options, slopes_option
from .output import into_folder, output_options
from .verb import several


class NamesType(ParsedType):
    """One or several names, separated by commas."""

    name = "NAME,..."

    def parsed(self, text: str) -> Any:
        return tuple(part.strip() for part in text.split(",") if part.strip())


# Of the body, of the fit, of the reading, of what is written.
fit_options = several(
    body_options,
    click.option("--free", multiple=True, type=NamesType(),
                 help="Also free: P0, compliance, E:LAYER, h:LAYER (thickness), range or stress (of adhesion), drift, "
                 "hysteresis, creep (of a raw record's positions), surface_tension."),
    click.option("--fix", multiple=True, type=NamedType(),
                 help='Known: w="50 mJ/m^2", delta0=0, modulus=1, E_star="1 MPa".'),
    click.option("--start", multiple=True, type=NamedType(), help="Starting value, beside those found in the data."),
    click.option("--bound", multiple=True, type=NamedType(),
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
    click.option("--noise", multiple=True, type=ScaleType(),
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
    click.option("--tip-radius", multiple=True, type=LENGTH_ABOVE_0,
                 help="With --shared or surface_tension: of each file, or of all [default: BODY's]."),
    click.option("--surface", type=click.Choice(["sliding", "sticking", "both"]),
                 help="Of the body, instead of its own; both: under either, and what the data prefer."),
    click.option("--uncertain", multiple=True, type=NamedType(),
                 help="Standard deviation of an input, carried on: radius=3%, stiffness=10%, thickness=5%."),
    slopes_option,
    reading_options,
    limits_options,
    parallel_options,
    into_folder("Folder [default: BODY's]."),
    output_options(plots=f"Draw nothing (else up to {SHOWN} curves are drawn).", json="Print the summary as JSON."),
)  # fmt: skip
