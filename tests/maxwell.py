"""A law of relaxation of one's own, all of it in this module: Maxwell's, which relaxes to nothing."""

from dataclasses import dataclass

import numpy as np

from jkrcli.bodies.problem import Modes, Time, relaxation_law


@relaxation_law("maxwell")
@dataclass(frozen=True)
class Maxwell:
    """r = exp(-t/time): the standard solid with the ratio 0."""

    time: Time

    @property
    def relaxed(self) -> float | None:
        return 0.0

    def modes(self, lasting: float) -> Modes:
        return Modes(0.0, np.ones(1), np.array([1 / self.time]))
