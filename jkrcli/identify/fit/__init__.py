"""From measured curves to E*, w and the zero points: orthogonal distances to the two-parameter family of one series."""

from __future__ import annotations

from .body import Body
from .fitting import fit
from .parameters import Parameter
from .result import Estimate, Fit
from .settings import Settings

__all__ = ["Body", "Estimate", "Fit", "Parameter", "Settings", "fit"]
