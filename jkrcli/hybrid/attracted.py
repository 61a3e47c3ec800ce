"""The kernel of a cylinder as far as adhesion of finite range reaches around a contact."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace

from ..adhesion.finite_range import KernelReached
from ..base.errors import NOTICEABLE, Refusal
from ..base.numerics import UNSEEN
from ..base.units import show
from ..bodies.problem import Problem
from ..series import KeptKernel
from .kernel import AdaptiveKernel
from .options import HybridOptions

TOLERANCES = (HybridOptions.tolerance, UNSEEN, NOTICEABLE)  # the first that is met; its error is stated


@dataclass(frozen=True, eq=False)
class AttractedCylinder:
    """The bodies of a ``problem`` with side walls, whose kernel is computed anew for each reach."""

    problem: Problem

    @property
    def _body(self) -> AdaptiveKernel:
        return AdaptiveKernel(self.problem.indenter, self.problem.specimen, TOLERANCES[0])

    @property
    def limit(self) -> float:
        """The radius [m] to which attraction may reach: near the side."""
        return self._body.limit

    def seconds(self, reach: float) -> float:
        """CPU seconds, about, of the kernel up to ``reach`` [m]."""
        return self._body.expected_cost(self._body.levels(reach))[0]

    def reached(self, reach: float, kept: KeptKernel | None = None) -> KernelReached:
        """The kernel up to ``reach`` [m] at the first tolerance that is met: that which was ``kept`` where it reaches
        and meets it. Refusal where none is met."""
        if kept is not None and reach <= kept.reach and kept.errors.sum(axis=0).max() <= TOLERANCES[0]:
            contact, errors = self._body.from_kept(kept)
            return contact.attraction, errors.at
        for tolerance in TOLERANCES:
            with contextlib.suppress(Refusal):
                contact, errors, *_ = replace(self._body, tolerance=tolerance).accurate(reach)
                return contact.attraction, errors.at
        raise Refusal(
            f"adhesion of finite range: the error of the cylinder's Green's function exceeds {TOLERANCES[-1]:g} within "
            f"{show(reach, 'length')}, the radius of the cohesive zone: reduce the load, or give a larger stress (a "
            "shorter range)"
        )
