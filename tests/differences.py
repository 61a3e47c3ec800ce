"""A slopes rule of one's own, all of it in this module: differences of neighbouring points, in logarithms."""

import numpy as np

from jkrcli.adhesion.rules import Rule, register
from jkrcli.adhesion.slopes import Slopes
from jkrcli.base.errors import Unknown
from jkrcli.series import Series


def differences(series: Series) -> Slopes:
    """S and S' by central differences; no error is known."""
    S = series.P / series.delta * np.gradient(np.log(series.P), np.log(series.delta))
    dS = S / series.a * np.gradient(np.log(S), np.log(series.a))
    return Slopes(S, dS, "differences", Unknown("not estimated"))


register(Rule("differences", "Differences of neighbouring points, in logarithms.", differences))
