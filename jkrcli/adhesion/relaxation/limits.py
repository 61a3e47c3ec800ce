"""The limits in which adhesion on a body that relaxes is known: it is elastic in cycles very fast and very slow."""

from __future__ import annotations

from ...base import InputError
from ...bodies import Relaxation


def limits_of(law: Relaxation) -> dict[str, float]:
    """The moduli over those at t = 0 in each limit, by its name; InputError for a law that has none."""
    if law.relaxed is None:
        raise InputError(
            "cycle: a power law has neither an instant nor a relaxed modulus, between which adhesion is: take the law "
            "sls or prony, or no adhesion, --w-approach 0"
        )
    return {"very fast": 1.0} | ({"very slow": law.relaxed} if law.relaxed > 0 else {})
