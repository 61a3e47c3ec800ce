"""What a law w(v) of the same material says of a course in which the bulk relaxes.

Tests of adhesion are often evaluated as if the bulk were relaxed and only the crack lost energy, by a work of adhesion
that grows with the speed v of the contact line. For a cohesive stress sigma that law is known. In a steady crack with
the energy release rate G of the relaxed modulus E_inf the zone is L long, and its end, a time t(x) = (L - x)/v behind
the place x, has opened by the compliance J of the moduli relaxed (Schapery, Int. J. Fract. 11 (1975) 141; Greenwood,
J. Phys. D 37 (2004) 2557):

    L = pi E_inf G/(4 sigma^2),     w/G = int_0^1 F'(y) J((1 - y) L/v)/J(infinity) dy,     F' = artanh(sqrt(y)),

from G = w at rest to w E_0/E_inf where nothing relaxes at the tip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base.errors import InputError, JkrError, Refusal, Unknown
from ..base.numerics import Array
from ..bodies.materials import Modes
from .interpolation import Nonadhesive
from .rate import History, RateContact
from .relaxing_adhesion import AdhesiveHistory

CRACK_ROWS = 200  # choice: of the law; between them it is interpolated in logs
CRACK_NEAREST = 1e-5  # choice: of the range of G, how near to its ends the law is known; beyond it is straight
CRACK_NODES = 200  # choice: of the integral over the zone, good to 1e-6
CRACK_DECADES = 12  # choice: of speeds about the zone's length over the times of relaxation, in which v is looked for
CRACK_HALVINGS = 60  # theory: of their logs, to rounding
ENOUGH = 0.1  # choice: of the force and of the way to pull-off, up to which a rate law will do
TABLE_ROWS = 400  # choice: of a piece, between which the law's course is interpolated


def creep(modes: Modes) -> tuple[float, Array, Array]:
    """The creep function of r(t) = ``modes``, r(0) = 1: J_inf, weights c, rates q [1/s] of J_inf - sum c exp(-q t).

    Under a constant load W = 1 + w xi and dxi/dt = k (W - xi) of every mode.
    """
    A = modes.rates[:, None] * (modes.weights - np.eye(modes.rates.size))
    q, vectors = np.linalg.eig(A)
    settled = -np.linalg.solve(A, modes.rates)
    c = (modes.weights @ vectors) * np.linalg.solve(vectors, settled)
    return 1 + float(modes.weights @ settled), np.real(c), -np.real(q)


@dataclass(frozen=True, eq=False)
class CrackRate:
    """The law of a crack under a cohesive ``stress`` [Pa] and ``w`` [J/m^2] in a body of the instant modulus ``E_star``
    [Pa] and ``modes`` of relaxation, w(v) on its relaxed moduli."""

    w: float
    stress: float
    E_star: float
    modes: Modes

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """log v and log(G/w - 1)."""
        relaxed = self.modes.relaxed
        most = 1 / relaxed - 1
        side = np.geomspace(CRACK_NEAREST, 0.5, CRACK_ROWS // 2)
        excess = most * np.concatenate([side, 1 - side[-2::-1]])
        G = self.w * (1 + excess)
        L = math.pi * relaxed * self.E_star * G / (4 * self.stress**2)
        x, weights = np.polynomial.legendre.leggauss(CRACK_NODES)
        part = (x + 1) / 2  # y = 1 - part^2: F' is singular at the zone's end, as a log
        density = np.arctanh(np.sqrt(1 - part**2)) * part * weights
        J_inf, c, q = creep(self.modes)

        def opened(log_v: Array) -> Array:
            times = part**2 * (L / np.exp(log_v))[:, None]
            return 1 - np.exp(-np.multiply.outer(times, q)) @ c @ density / J_inf

        reach = CRACK_DECADES * math.log(10)
        low, high = np.log(L * q.min()) - reach, np.log(L * q.max()) + reach
        for _ in range(CRACK_HALVINGS):
            middle = (low + high) / 2
            slow = opened(middle) > self.w / G
            low, high = np.where(slow, middle, low), np.where(slow, high, middle)
        return low, np.log(excess)

    def work(self, w0: Any, v: Any) -> Any:
        """w [J/m^2] at the speeds ``v`` [m/s]."""
        log_v, log_excess = self._table
        x = np.log(np.maximum(v, np.finfo(float).tiny))
        return w0 * (1 + np.exp(np.interp(x, log_v, log_excess) + np.minimum(x - log_v[0], 0.0)))

    def speed(self, w0: float, excess: float) -> float:
        """The speed [m/s] at which w is ``excess`` [J/m^2] beyond ``w0``; infinite beyond the largest w."""
        log_v, log_excess = self._table
        x = math.log(max(excess / w0, np.finfo(float).tiny))
        if x >= log_excess[-1]:
            return math.inf
        return math.exp(float(np.interp(x, log_excess, log_v)) + min(x - float(log_excess[0]), 0.0))


@dataclass(frozen=True, eq=False)
class RateLawCourse:
    """What the ``law`` of the same material says, ``history``, where only the contact line of a relaxed specimen loses
    energy, of what happens in ``course``."""

    course: AdhesiveHistory
    law: CrackRate
    history: History

    @property
    def force_difference(self) -> float:
        """Pull-off force of the law over that of the course, less 1."""
        return self.history.pull_off.P / self.course.pull_off.P - 1

    @property
    def depth_difference(self) -> float:
        """Displacement at pull-off of the law less that of the course [m]."""
        return self.history.pull_off.delta - self.course.pull_off.delta

    @property
    def stroke(self) -> float:
        """The way of the tip from its turn to pull-off in the course [m]."""
        return float(np.max(self.course.rows[:, 3])) - self.course.pull_off.delta

    @property
    def enough(self) -> bool:
        """Whether the law tells force and place of pull-off to a tenth."""
        return max(abs(self.force_difference), abs(self.depth_difference) / self.stroke) < ENOUGH

    def columns(self, t: Array) -> dict[str, Array]:
        """Radius, displacement and load by the law at the times ``t`` [s] of the course."""
        table = self.history.table(TABLE_ROWS)
        return {f"rate_{name}": np.interp(t, table["t_s"], table[name]) for name in ("a_m", "delta_m", "P_N")}


def follow_crack_law(course: AdhesiveHistory, relaxed: Nonadhesive) -> RateLawCourse | Unknown:
    """The same program on the ``relaxed`` specimen, by the law w(v) of its cracks."""
    contact = course.contact
    law = CrackRate(contact.law.w, contact.law.stress, contact.problem.E_star, contact.relaxation.modes(1.0))
    rated = RateContact(relaxed, law, law.w, law.w, contact.stiffness)
    try:
        history = rated.history(course.program, course.course.rows[0].a if contact.rests else None)
    except (JkrError, Refusal, InputError) as error:
        return Unknown(str(error))
    if history.out_of_series is not None:
        return Unknown(history.out_of_series)
    return RateLawCourse(course, law, history)
