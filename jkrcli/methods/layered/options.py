"""The options of the method ``layered``, and what is known of it before it is imported."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ...base import Ranged, check_ranges
from ..protocol import Descriptor, register


@dataclass(frozen=True)
class LayeredOptions:
    """Options: ``tolerance``, the relative error of delta, P, S and S' at every radius."""

    tolerance: Annotated[float, Ranged("number", least=1e-12, most=1e-2)] = 1e-8

    def __post_init__(self) -> None:
        check_ranges(self, "layered")


SENTENCE = "The exact contact equation of any stack of layers much wider than the contact; no mesh."
SOLVER = "jkrcli.methods.layered.layered:Layered"
register(
    Descriptor(
        "layered", SENTENCE, SOLVER, 20, LayeredOptions, exact=True, kernel=True, tension=True, coating=True
    )
)  # fmt: skip
