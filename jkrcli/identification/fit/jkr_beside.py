"""JKR beside a fit with adhesion of finite range: how much worse it describes the same rows."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ...base import JkrError, Unknown
from .body import FittedBody
from .points import Points
from .result import JKRBeside
from .search import Minimum, minimise, robust, search
from .settings import Settings


def jkr_beside(minimum: Minimum, body: FittedBody, points: Points, settings: Settings) -> JKRBeside | Unknown:
    """The nearest curve of JKR to the rows of ``minimum``, in its scales; Unknown where none comes near."""
    plain = settings.without_range
    try:
        near = search(body, points, plain)
        objective = replace(near.objective, scales=minimum.objective.scales)
        jkr = robust(minimise(objective, near.x), settings.loss)
        jkr = minimise(objective, jkr.x, settings.loss, minimum.width).settled()  # the same turn of a robust loss
    except JkrError as error:
        return Unknown(str(error))
    values = objective.values(jkr.x)
    rms, with_range = (math.sqrt(float(np.mean(item.distances.residuals**2))) for item in (jkr, minimum))
    E_star = values["modulus"] * body.problem.E_star
    return JKRBeside(E_star, values["w"], rms, with_range, jkr.cost - minimum.cost, values)
