"""Fits of E*, w and the zero points to measured curves: orthogonal distances to the two-parameter family of one series.

settings: what is asked; points: which rows; model: what an instrument reads; search: the nearest curve; confidence.
"""

from __future__ import annotations

from .body import FittedBody
from .fitting import fit
from .result import Fit, FittedValue
from .settings import Parameter, Settings

__all__ = ["Fit", "FittedBody", "FittedValue", "Parameter", "Settings", "fit"]
