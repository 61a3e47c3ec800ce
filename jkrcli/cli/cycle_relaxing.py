"""``jkr cycle`` of a specimen that relaxes: over time without adhesion, with adhesion its limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base import InputError
from ..bodies import Relaxation
from .cycle_rate import RateOptions, Turn, flag, program_of

if TYPE_CHECKING:
    from ..beside.analysis import Analysis
    from ..report.relaxation import CycledRelaxing


def limits_of(law: Relaxation, rates: RateOptions) -> dict[str, float]:
    """The moduli over those at t = 0 in the limits that are known where surfaces adhere, by the name of each."""
    if law.relaxed is None:
        raise InputError(
            "cycle: a power law has neither an instant nor a relaxed modulus, between which adhesion is: take the law "
            "sls or prony, or no adhesion, --w-approach 0"
        )
    if rates.rate is None and rates.given:
        raise InputError(
            f"cycle: {flag(rates.given[0])}: adhesion on a body that relaxes is known in the limits of very fast and "
            "very slow cycles alone, which do not depend on time: leave it out, or give --w-approach 0"
        )
    return {"very fast": 1.0} | ({"very slow": law.relaxed} if law.relaxed > 0 else {})


def run(
    body: Analysis, law: Relaxation, stiffness: float, turn: Turn, points: int, rates: RateOptions
) -> CycledRelaxing:
    """What happens over time without adhesion."""
    from ..adhesion import RelaxingContact
    from ..report.relaxation import CycledRelaxing

    if rates.rate is not None:
        raise InputError("cycle: --rate needs adhesion: give --w-approach, or leave it out")
    if rates.speed is None and rates.program is None:
        raise InputError('cycle: the specimen relaxes: say what the device does, --speed "10 um/s" or --program TABLE')
    contact = RelaxingContact(body.jkr.nonadhesive, law, stiffness)
    return CycledRelaxing.of(contact, program_of(contact, rates, turn), body.path, points)
