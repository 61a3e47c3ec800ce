"""What a solve may cost: told before it begins where it is much, refused beyond limits that the user can raise."""

from __future__ import annotations

from dataclasses import dataclass

from ..base import SHARE, SILENCE, Refusal, duration, free_memory
from .protocol import Forecast

LARGE = 2048.0  # choice: MiB from which on the memory is announced
LESS = "fewer points, larger elements or a cheaper method"  # what makes a solve cheaper


@dataclass(frozen=True)
class Limits:
    """Limits of a solve that is begun: most ``memory`` [GiB] (None: ``SHARE`` of what is free) and CPU ``hours``."""

    memory: float | None = None
    hours: float = 1.0


def admit(what: str, forecast: Forecast, limits: Limits, less: str = LESS) -> str | None:
    """A sentence on what ``what`` will cost, None where that is little; Refusal beyond the limits, with the advice to
    ask for ``less``."""
    memory, hours = forecast.memory_mib / 1024, forecast.seconds / 3600
    most = free_memory() * SHARE / 1024 if limits.memory is None else limits.memory
    needs = f"{what} would need about {memory:.3g} GiB of memory and {duration(forecast.seconds)} of CPU time"
    remedy = f"ask for {less}, or raise the limit by"
    if not memory <= most:
        raise Refusal(
            f"{needs}, the limit is {most:.3g} GiB: {remedy} --limit-memory {_raised(memory)}"
            + (" if the machine has that much" if limits.memory is None else "")
        )
    if not hours <= limits.hours:
        raise Refusal(f"{needs}, the limit is {limits.hours:g} h: {remedy} --limit-time {_raised(hours)}")
    if forecast.seconds <= SILENCE and forecast.memory_mib < LARGE:
        return None
    return needs.replace("would need", "needs")


def _raised(value: float) -> str:
    """A limit that leaves some room above ``value``."""
    return f"{float(f'{1.3 * value:.1e}'):g}"
