"""Many curves on one body: in parallel, each on its own, the bad ones reported and skipped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from ...base.errors import InputError, JkrError
from ...base.executors import Pool, completed
from ...data.measured import Curve
from .body import Body
from .fitting import fit
from .result import Fit
from .settings import Settings

CHUNK = 20  # curves per task


@dataclass(frozen=True, eq=False)
class Failure:
    """A curve that could not be fitted; ``lines``: why, one sentence each."""

    curve: Curve
    lines: tuple[str, ...]


def fit_all(body: Body, curves: Sequence[Curve], settings: Settings, pool: Pool) -> list[Fit | Failure]:
    """Fits of all curves in their order; any exception but the project's own is a bug and shows itself."""
    found: list[Fit | Failure | None] = [None] * len(curves)
    work = partial(_one, body, settings)
    for index, result in completed(pool, work, curves, "fitting", chunk=CHUNK):
        if isinstance(result, JkrError):
            lines = result.lines if isinstance(result, InputError) else (str(result),)
            found[index] = Failure(curves[index], lines)
        elif isinstance(result, Exception):
            raise result
        else:
            found[index] = result
    return [item for item in found if item is not None]


def _one(body: Body, settings: Settings, curve: Curve) -> Fit:
    return fit(body, curve, settings)
