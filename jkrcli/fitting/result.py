"""The result of a fit: parameters with their uncertainty, residuals, and what a reader should know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..base.errors import Unknown
from ..base.numerics import Array
from ..data.curve import Pixel
from .alternative_tests import Verdict
from .least_squares import Structure
from .parameters import Answer, FittedValue
from .settings import Settings


@dataclass(frozen=True)
class JKRBeside:
    """JKR's nearest curve to rows that were fitted with a range: ``E_star`` [Pa], ``w`` [J/m^2], the root mean squares
    of the residuals, ``rms`` and ``rms_of_range``, in the same units, and how much larger half the sum of losses
    is; ``values`` of all its parameters, SI."""

    E_star: float
    w: float
    rms: float
    rms_of_range: float
    excess: float
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Further:
    """A measurement in ``words``, and the relative standard errors of E* and w with it; of "now" without."""

    words: str
    E_star: float
    w: float


@dataclass(frozen=True, eq=False, kw_only=True)
class Fit(Answer):
    """One fitted curve: plain numbers, light to send between processes.

    ``name`` of the curve in its ``file``, ``where``: both, for messages. ``estimates``: the parameters, then what
    follows from them (E_star, moduli of layers); ``covariance``: of the free parameters ``free``, SI, None where
    the data do not tell them apart; ``samples``: their bootstrap values (n, free). ``data``: the readings that were
    used, of the ``rows`` of the curve; ``left_out``: why others were not. ``a``: contact radius at each foot point
    [m]; ``residuals`` (k, n): signed normal distances (k = 1), or for three columns distance vectors (k = 3), in
    units of ``scales``; ``scatter``: their standard deviation, ``dof`` their degrees of freedom. ``line``: the
    fitted curve, readings by column and "a". ``warnings``: sentences with numbers. ``flags``: what is wrong with a
    raw record, in a word or two each; ``surface``: what the surfaces were taken to do; ``tip``: what stands for the
    tip, where that is a convention; ``held``: what the free rows of a raw record hold beside a base line;
    ``not_included``: inputs that no error holds; ``quality``:
    of a raw record, between 0 and 1, with its parts, None where readings were prepared; ``adhesion``: its largest
    tension on retraction [N], None where there is none; ``directions``: of it that were fitted. ``pixel``: in a map.
    ``jkr``: of a fit with a range, JKR beside it; ``range_left``: of a fit of JKR, the longest range [m] that the rows
    leave, None
    where none was tried; ``verdict``: of a raw record, on its alternatives; ``plan``: the errors that
    further measurements would leave, on request.
    """

    name: str
    file: str
    where: str
    samples: Array | None
    data: Mapping[str, Array]
    rows: Array
    left_out: tuple[str, ...]
    a: Array
    residuals: Array
    scales: Mapping[str, float]
    scatter: float
    structure: Structure
    line: Mapping[str, Array]
    evaluations: int
    settings: Settings
    flags: tuple[str, ...] = ()
    quality: Mapping[str, float] | None = None
    surface: str = "sliding"
    tip: str = ""
    held: tuple[str, ...] = ()
    not_included: str = ""
    adhesion: float | None = None
    pixel: Pixel | None = None
    jkr: JKRBeside | Unknown | None = None
    range_left: float | None = None
    directions: str = ""
    verdict: Verdict | None = None
    plan: tuple[Further, ...] = ()

    @property
    def work(self) -> FittedValue:
        """The work of adhesion; of an approach alone its own."""
        return self.estimate("w" if any(item.name == "w" for item in self.estimates) else "w_approach")
