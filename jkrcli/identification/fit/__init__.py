"""From measured curves to E*, w and the zero points: orthogonal distances to the two-parameter family of one series."""

from __future__ import annotations

from .body import FittedBody
from .fitting import fit
from .result import Fit, FittedValue
from .settings import Parameter, Settings

__all__ = ["Fit", "FittedBody", "FittedValue", "Parameter", "Settings", "fit"]
