"""The method ``hybrid`` as it is known before its solver is imported: its options and its place among the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from ..base.arguments import Checked
from ..base.units import Ranged
from ..methods.protocol import Descriptor, register


@dataclass(frozen=True)
class HybridOptions(Checked):
    """Options: ``tolerance``, the relative error of delta, P, S and S' at every radius."""

    where: ClassVar[str] = "hybrid"
    tolerance: Annotated[float, Ranged("number", least=1e-8, most=1e-2)] = 1e-5


register(
    Descriptor(
        "hybrid",
        "The contact equation with a kernel that finite elements compute: cylinders and other smooth changes.",
        "jkrcli.hybrid.solver:Hybrid", 30, HybridOptions, kernel=True, coating=True,
    )
)  # fmt: skip
