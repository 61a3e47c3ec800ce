"""Laws by which the moduli of a specimen relax: one function r(t) for all its layers, at constant Poisson's ratios.

Each law is a class that registers itself. r is given as a sum of exponentials, which every step in time carries on
exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, Protocol, TypeAlias

import numpy as np

from ..base import Array, InputError, Ranged, Registry, check_ranges, show

Time: TypeAlias = Annotated[float, Ranged("time", above=0)]
Share: TypeAlias = Annotated[float, Ranged("number", above=0, most=1)]

RELAXATIONS = Registry()
relaxation_law = RELAXATIONS.register  # decorator: the name by which ``relaxation = { law = ... }`` calls it


@dataclass(frozen=True)
class SpectrumTuning:
    """The exponentials that stand for a power law over a program that lasts T."""

    step: float = 0.4  # theory: of log rates; the trapezoidal rule errs by exp(-pi^2/0.4) = 2e-11
    slowest: float = 1e-5  # theory: rate times T below which one exponential stands for all; errs by its square
    fastest: float = 1e10  # theory: the same above which one does, of equal area and moment


TUNING = SpectrumTuning()


class Modes(NamedTuple):
    """r(t) = ``relaxed`` + sum of ``weights`` exp(-``rates`` t); weights and rates [1/s] (m,)."""

    relaxed: float
    weights: Array
    rates: Array

    def __call__(self, t: Any) -> Any:
        """r at the times ``t`` >= 0 [s] of any shape."""
        return self.relaxed + np.exp(-np.multiply.outer(t, self.rates)) @ self.weights


class Relaxation(Protocol):
    """r(t) of the moduli: a frozen dataclass whose fields are its parameters."""

    @property
    def relaxed(self) -> float | None:
        """The relaxed over the instant modulus; None where there is no instant modulus."""

    def modes(self, lasting: float) -> Modes:
        """r over the times up to ``lasting`` [s]."""


@relaxation_law("sls")
@dataclass(frozen=True)
class StandardSolid:
    """r = ratio + (1 - ratio) exp(-t/time), the standard linear solid; E is the instant modulus, ``ratio`` the relaxed
    one over it."""

    ratio: Annotated[float, Ranged("number", least=0, below=1)]
    time: Time

    def __post_init__(self) -> None:
        check_ranges(self, "relaxation")

    @property
    def relaxed(self) -> float | None:
        return self.ratio

    def modes(self, lasting: float) -> Modes:
        return Modes(self.ratio, np.array([1 - self.ratio]), np.array([1 / self.time]))

    def __str__(self) -> str:
        return f"standard linear solid, ratio = {self.ratio:.4g}, time = {show(self.time, 'time')}"


@relaxation_law("power")
@dataclass(frozen=True)
class PowerRelaxation:
    """r = (t/time)^-exponent: E is the modulus at ``time``; there is neither an instant nor a relaxed one.

    t^-x Gamma(x) = int exp(x u - t exp(u)) du, by the trapezoidal rule (Beylkin and Monzon, Appl. Comput. Harmon. Anal.
    28 (2010) 131).
    """

    time: Time
    exponent: Annotated[float, Ranged("number", above=0, below=1)]

    def __post_init__(self) -> None:
        check_ranges(self, "relaxation")

    @property
    def relaxed(self) -> float | None:
        return None

    def modes(self, lasting: float) -> Modes:
        h, x, T = TUNING.step, self.exponent, lasting / self.time
        low, high = math.floor(math.log(TUNING.slowest / T) / h), math.ceil(math.log(TUNING.fastest / T) / h)
        u = h * np.arange(low, high + 1)
        slow, slower = (math.exp(p * u[0]) / math.expm1(p * h) for p in (x, x + 1))  # sums below: weight, weight x rate
        fast, faster = (math.exp(-p * u[-1]) / math.expm1(p * h) for p in (1 - x, 2 - x))  # above: over rate, rate^2
        weights = np.concatenate([[slow], np.exp(x * u), [fast**2 / faster]])
        rates = np.concatenate([[slower / slow], np.exp(u), [fast / faster]])
        return Modes(0.0, weights * h / math.gamma(x), rates / self.time)

    def __str__(self) -> str:
        return f"power law, exponent = {self.exponent:.4g}, E at {show(self.time, 'time')}"


@relaxation_law("prony")
@dataclass(frozen=True)
class Prony:
    """r = 1 - sum of g_i (1 - exp(-t/t_i)): ``weights`` g_i > 0 of sum at most 1, relaxation ``times`` t_i [s]; E is
    the instant modulus."""

    weights: tuple[Share, ...]
    times: tuple[Time, ...]

    def __post_init__(self) -> None:
        if len(self.weights) != len(self.times) or not self.weights:
            raise InputError(
                f"relaxation: needs as many times as weights, got {len(self.weights)} weights, {len(self.times)} times"
            )
        if not min(self.weights) > 0 or sum(self.weights) > 1 + 1e-12:
            raise InputError(f"relaxation: the weights must be > 0, their sum at most 1, got {list(self.weights)}")
        if not min(self.times) > 0:
            raise InputError(f"relaxation: the times must be > 0 s, got {list(self.times)}")

    @property
    def relaxed(self) -> float | None:
        return max(0.0, 1 - sum(self.weights))

    def modes(self, lasting: float) -> Modes:
        return Modes(self.relaxed or 0.0, np.array(self.weights), 1 / np.array(self.times))

    def __str__(self) -> str:
        pairs = zip(self.weights, self.times, strict=True)
        return "prony, " + ", ".join(f"{weight:.4g} within {show(time, 'time')}" for weight, time in pairs)


def relaxing(law: Relaxation | None) -> list[str]:
    """A warning of what a result of constant moduli means for a viscoelastic specimen, which relaxes by ``law``; none
    for an elastic one."""
    if law is None:
        return []
    begin = "the specimen relaxes: "
    if law.relaxed is None:
        return [f"{begin}the moduli here are those at the law's time; without adhesion jkr cycle --speed follows them"]
    fast = f"{begin}this is the limit of very fast cycles, with the moduli at t = 0"
    if not law.relaxed > 0:
        return [f"{fast}; without adhesion jkr cycle --speed follows them over time"]
    return [
        f"{fast}, and no bound: pulled at once from rest, contact holds up to {1 / law.relaxed:.3g} times as much; jkr "
        "pull-off and jkr cycle give the force by the history"
    ]
