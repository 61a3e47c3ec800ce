"""What is asked of a fit: parameters, rows, noise, loss and confidence."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from ...base.errors import InputError
from .parameters import Parameter
from .points import Branch, Segment

Loss = Literal["linear", "soft_l1", "huber", "cauchy"]
Confidence = Literal["covariance", "profile", "bootstrap"]

AS_IN_THE_CASE = {"modulus": 1.0, "delta0": 0.0, "P0": 0.0, "compliance": 0.0}


@dataclass(frozen=True)
class Settings:
    """What to fit, and how.

    ``parameters``: in the order of the tables; w must be among them, of the other common ones those that are left out
    are fixed as in the case. ``segment``: None takes the retraction where the curve names one, else all rows.
    ``noise``: standard deviation of the readings by column, SI; found from the record where it is not given.
    ``level``: of the confidence intervals. ``uncertain``: standard deviations of inputs of the body ("nu:film",
    "h:film", SI), carried through. ``samples, seed``: of the bootstrap.
    """

    parameters: tuple[Parameter, ...]
    segment: Segment | None = None
    branch: Branch = "all"
    noise: Mapping[str, float] = field(default_factory=dict)
    loss: Loss = "linear"
    confidence: Confidence = "covariance"
    level: float = 0.95
    uncertain: Mapping[str, float] = field(default_factory=dict)
    samples: int = 200
    seed: int = 0

    def __post_init__(self) -> None:
        given = {parameter.name for parameter in self.parameters}
        if "w" not in given:
            raise InputError("fit: w must be free or fixed at a value")
        left_out = (Parameter(name, False, value) for name, value in AS_IN_THE_CASE.items() if name not in given)
        object.__setattr__(self, "parameters", (*self.parameters, *left_out))
        if not 0.5 <= self.level < 1:
            raise InputError(f"fit: the confidence level must be between 0.5 and 1, got {self.level:g}")
        for name, value in self.noise.items():
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"fit: the noise of {name} must be > 0, got {value:g}")
        if not self.free:
            raise InputError("fit: no parameter is free")

    @property
    def free(self) -> tuple[Parameter, ...]:
        return tuple(parameter for parameter in self.parameters if parameter.free)

    def parameter(self, name: str) -> Parameter | None:
        """The parameter called ``name``, None where it plays no part."""
        return next((parameter for parameter in self.parameters if parameter.name == name), None)
