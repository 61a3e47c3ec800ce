"""A law of the work of adhesion over speed of one's own, all of it in this module: w grows with the speed itself."""

from dataclasses import dataclass
from typing import Any

from jkrcli.viscoelastic.rate import Speed, rate_law


@rate_law("linear")
@dataclass(frozen=True)
class LinearRate:
    """w = w0 (1 + v/v0): the power law with n = 1."""

    v0: Speed

    def work(self, w0: Any, v: Any) -> Any:
        return w0 * (1 + v / self.v0)

    def speed(self, w0: float, excess: float) -> float:
        return self.v0 * excess / w0
