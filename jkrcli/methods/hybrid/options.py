"""The options of the method ``hybrid``, and what is known of it before it is imported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ...base import Ranged, check_ranges
from ..protocol import Descriptor, register


@dataclass(frozen=True)
class HybridOptions:
    """Options: ``tolerance``, the relative error of delta, P, S and S' at every radius."""

    tolerance: Annotated[float, Ranged("number", least=1e-8, most=1e-2)] = 1e-5

    def __post_init__(self) -> None:
        check_ranges(self, "hybrid")


SENTENCE = "The contact equation with a kernel that finite elements compute: cylinders and other smooth changes."
register(Descriptor("hybrid", SENTENCE, "jkrcli.methods.hybrid.method:Hybrid", 30, HybridOptions, kernel=True))
