"""What the Python interface offers of fits of laws over time; they stand on the wing of measured curves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated, Any, TypeAlias

from ..api import Body, Known, SlopesRule
from ..base import units
from ..base.arguments import OneOf, checked
from ..base.errors import InputError
from ..measured.curve import Curve
from ..measured.forward_model import FittedBody
from ..measured.functions import OneCurve, RelaxationName, fit, instead
from ..measured.parameters import Answer
from . import law_fits  # noqa: F401 - registers what fits of laws say
from .rate import RATE_LAWS
from .rate_fit import RateFit, rate_fit, rate_settings
from .relaxation_fit import relaxation_fit
from .shared_speeds import SharedSpeedsFit, shared_speeds_fit
from .timed_record import RelaxationFit, relaxation_settings

__all__ = ["identify_law", "identify_relaxation"]
RateName: TypeAlias = Annotated[str, OneOf(RATE_LAWS)]


def fit_laws(
    body: FittedBody, curves: Sequence[Curve], law: str | None, relaxation: str | None, free: Iterable[str],
    fix: units.Named, **options: Any,
) -> RateFit | SharedSpeedsFit | RelaxationFit:  # fmt: skip
    """The fits of `fit` by a ``law`` of w over speed, or by one of ``relaxation``, or by both."""
    if relaxation is None:
        assert law is not None
        return rate_fit(body, curves, rate_settings(body, law, free, fix, **options))
    names = (relaxation, fix, free, body.problem.E_star, body.range_of_case, law)
    settings = relaxation_settings(*names, **options)
    if law or options.get("shared"):
        return shared_speeds_fit(body, curves, settings)
    if len(curves) > 1:
        raise InputError(f"fit: {len(curves)} curves: name what they share, shared=[...], or fit each by itself")
    return relaxation_fit(body, curves[0], settings)


@checked
def identify_law(
    body: Body, measured: Iterable[OneCurve], law: RateName = "power", free: Iterable[str] = (), fix: Known = None,
    slopes: SlopesRule = "auto", relaxation: RelaxationName | None = None, **options: Any,
) -> Answer:  # fmt: skip
    """Deprecated: `fit` with ``law``."""
    instead("identify_law", f'call fit with law="{law}"')
    return fit(body, tuple(measured), free, fix, slopes, law=law, relaxation=relaxation, **options)


@checked
def identify_relaxation(
    body: Body, measured: OneCurve, law: RelaxationName = "sls", fix: Known = None, slopes: SlopesRule = "auto",
    free: Sequence[str] = (), **options: Any,
) -> Answer:  # fmt: skip
    """Deprecated: `fit` with ``relaxation``."""
    instead("identify_relaxation", f'call fit with relaxation="{law}"')
    return fit(body, measured, free, fix, slopes, relaxation=law, **options)
