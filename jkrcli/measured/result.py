"""The result of a fit: parameters with their uncertainty, residuals, and what a reader should know."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeVar

from ..base.errors import JkrError, Unknown
from ..base.numerics import Array
from .curve import Pixel
from .grade import Grade, grade_of
from .least_squares import Structure
from .lockstep import Flow
from .parameters import Answer, FittedValue
from .score_tests import Verdict
from .settings import Settings

Found = TypeVar("Found")


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
    ``not_included``: inputs that no error holds; ``sizes``:
    of a raw record, of what stands against it, None where readings were prepared; ``adhesion``: its largest
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
    sizes: Mapping[str, float] | None = None
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

    @cached_property
    def grade(self) -> Grade | None:
        """How far the fit of a raw record is to be believed; None where readings were prepared."""
        if self.sizes is None:
            return None
        return grade_of(self.sizes, self.flags, self.estimate("E_star"), self.work, self.verdict)

    @property
    def work(self) -> FittedValue:
        """The work of adhesion; of an approach alone its own."""
        return self.estimate("w" if any(item.name == "w" for item in self.estimates) else "w_approach")


def later(fit: Fit, what: str, step: Callable[[], Fit | Flow[Fit]]) -> Flow[Fit]:
    """The result of a ``step`` after the ``fit``; where it fails, whatever it is, the fit as it was, and a warning that
    names ``what`` is left out: nothing after a fit costs the fit."""
    try:
        found = step()
        return found if isinstance(found, Fit) else (yield from found)
    except Exception as error:
        return without(fit, what, error)


def without(fit: Fit, what: str, error: Exception) -> Fit:
    """The fit with a warning on ``what`` is left out for an ``error``."""
    return replace(fit, warnings=(*fit.warnings, left_out(what, error)))


def attempted(what: str, step: Callable[[], Found], instead: Found, left: list[str]) -> Found:
    """What a ``step`` after a fit finds; where it fails, what there is ``instead``, and a sentence in ``left``."""
    try:
        return step()
    except Exception as error:
        left.append(left_out(what, error))
        return instead


def left_out(what: str, error: Exception) -> str:
    """A sentence on ``what`` is left out for an ``error``, whose words count where they are this program's."""
    reason = str(error) if isinstance(error, JkrError) else f"it cannot be computed here ({type(error).__name__})"
    return f"{what}: left out, {reason}"
