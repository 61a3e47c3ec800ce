"""A contact that adheres while its body relaxes, as the model of a fit.

No closed form is known: each evaluation is a march through the record (``relaxing_adhesion.py``). Loads scale with
the moduli, P(E, w, sigma) = E p(w/E, sigma/E). Marches are coarse while a minimum is sought, and derivatives are
secants as long as they foretell what a step changes (Broyden, Math. Comp. 19 (1965) 577).
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..adhesion.curve import Nonadhesive
from ..adhesion.device_path import Program
from ..adhesion.finite_range import AttractedBody, Range
from ..base.errors import InputError, SolveError
from ..base.numerics import MOST_STEPS, TINY, Array
from ..base.units import Ranged
from ..bodies.problem import Problem, Relaxation
from ..measured.forward_model import FittedBody
from .relaxing_adhesion import STEP_TOLERANCE, ZONE_POINTS, ZONE_SLOPE, RelaxingAdhesion

# How a march is followed while a minimum is sought.
# choice: the loads err by 1e-3 of the pull-off force, a twentieth of usual noise; the last steps are not coarse
MARCH_TOLERANCE = 16 * STEP_TOLERANCE
MARCH_POINTS = ZONE_POINTS // 5  # choice: the same
MARCH_ROOM = 1.1  # choice: of the reach of a march, that of the next, whose parameters are near
MARCH_ZONE = 0.25  # choice: of the largest contact radius, the zone where no range is known; its influence is stated
MARCH_APART = 1.5  # theory: rows from a jump, within which no row shows when it was
MARCH_NEAR = 8.0  # choice: rows from a jump of the model, within which that of the record is sought
MARCH_MODULI = 1e6  # choice: in those of the body, the moduli among which a search begins
MARCH_TRIED = 60  # choice: of them, between which their logs are interpolated
MARCH_MEAN = 3  # choice: rows to either side, of whose loads means are taken
MARCH_RATIOS = (0.15, 0.45)  # choice: with which a search begins
MARCH_SHARES = (0.0, 0.5, 1.0)  # choice: of the way from very fast to from rest, in the log of w, of starts
MARCH_TIMES = (0.1, 0.4)  # choice: the same, over the time in contact
MARCH_SEEN = 4.0  # theory: part of the pull-off force, beyond noise
MARCH_ROUNDS = 3  # choice: modulus and zero in turn, good to a tenth
SECANT_FORETOLD = 0.4  # choice: of a change, what secants may miss of it
SECANT_NOISE = 0.1  # choice: of the noise, what they may miss of any change
ADHESION = {"w": Ranged("work", above=0), "stress": Ranged("modulus", above=0), "range": Ranged("length", above=0)}


@dataclass(frozen=True, eq=False)
class AdhesiveMarch:
    """The bodies of a ``problem``, ``attracted``, whose series ends at the radius and displacement ``end`` [m], under
    marches of steps of a ``tolerance`` and ``points`` on the zone; jumps are spread ``over`` a time [s]."""

    problem: Problem
    attracted: AttractedBody
    end: tuple[float, float]
    over: float
    tolerance: float = MARCH_TOLERANCE
    points: int = MARCH_POINTS
    reach: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, body: FittedBody, over: float) -> AdhesiveMarch:
        """Of a ``body``; InputError where it has no kernel."""
        if body.no_range:
            raise InputError(body.no_range.replace("adhesion of finite range", "adhesion on a viscoelastic specimen"))
        end = float(body.series.a[-1]), float(body.series.delta[-1])
        return cls(body.problem, AttractedBody(body.problem), end, over)

    def states(
        self, law: Relaxation, values: Mapping[str, float], stiffness: float, program: Program, t: Array
    ) -> tuple[Array, Array, Array, Array]:
        """a [m], delta [m], P [N] over the modulus at the times ``t`` [s] of a ``program`` with the ``values`` of
        "modulus", "w" and "stress" or "range", in a device of ``stiffness`` over the modulus; the times of jumps."""
        w, length = values["w"] / values["modulus"], values.get("range")
        stress = None if length else values["stress"] / values["modulus"]
        contact = RelaxingAdhesion(
            self.problem, self.attracted, law, Range.of(w, stress=stress, length=length), self.end, stiffness,
            self.tolerance, self.points,
        )  # fmt: skip
        course = contact.course(program, self.tolerance, self.reach.get("", 0.0))
        if course.body.attraction.reach > self.reach.get("", 0.0):  # kept: the kernel is that of a reach
            self.reach[""] = min(MARCH_ROOM * course.body.attraction.reach, self.attracted.limit)
        return *course.states(t, self.over), np.array([jump.t for jump in course.jumps])

    def full(self) -> AdhesiveMarch:
        """The same by marches that are not coarse."""
        return replace(self, tolerance=STEP_TOLERANCE, points=ZONE_POINTS)

    def stress(self, w: float, E_star: float, radius: float) -> float:
        """The stress [Pa] whose zone is a part of the contact ``radius`` [m] wide."""
        return math.sqrt(ZONE_SLOPE * E_star * w / (MARCH_ZONE * radius))


@dataclass(frozen=True, eq=False)
class ElasticLimits:
    """What the adhesive curves of a ``body`` that does not relax say of a record: where a search begins."""

    body: Nonadhesive

    def work(self, modulus: float, force: float) -> float:
        """The work of adhesion [J/m^2] behind a pull-off ``force`` [N] with the ``modulus`` in those of the body."""
        a, P, S, dS = self.body.a, modulus * self.body.series.P, self.body.slopes.S, self.body.slopes.dS
        low, high = TINY, force**2 / float(np.min(modulus * S**2 * 4 * math.pi * a / dS))
        for _ in range(MOST_STEPS):
            w = (low + high) / 2
            pulled = float(np.max(S * np.sqrt(modulus * 4 * math.pi * w * a / dS) - P))
            low, high = (low, w) if pulled > force else (w, high)
        return high

    def modulus(self, delta: float, P: float, work: Callable[[float], float]) -> float:
        """The largest modulus, in those of the body, with which the load at ``delta`` [m] is ``P`` [N] under the
        ``work`` [J/m^2] of adhesion of each modulus."""
        a, series, slopes = self.body.a, self.body.series, self.body.slopes
        above, beyond = math.inf, MARCH_MODULI
        for modulus in np.geomspace(MARCH_MODULI, 1 / MARCH_MODULI, MARCH_TRIED).tolist():
            shift = np.sqrt(4 * math.pi * work(modulus) * a / (modulus * slopes.dS))
            there = series.delta - shift
            i = int(np.argmin(there))
            load = float(np.interp(delta, there[i:], (modulus * (series.P - slopes.S * shift))[i:]))
            if load <= P < above:
                part = (P - load) / (above - load) if math.isfinite(above) else 0.0
                return modulus * (beyond / modulus) ** part
            above, beyond = load, modulus
        return beyond

    def starts(
        self, t: Array, x: Array, P: Array, turn: float, shows: float, ranged: Callable[[float], float]
    ) -> list[dict[str, float]]:
        """Values to begin with for loads ``P`` [N] over a base line at places ``x`` [m] of the tip, where contact
        ``shows``: "modulus", "ratio", "time", "w", "delta0". With each of some ratios and times the pull-off force
        tells w in a very fast cycle, where it is elastic, from rest, where it is the ratio times that of the relaxed
        modulus (``adhesion/from_rest.py``), and between; the load at the ``turn`` [s] tells the modulus. ``ranged``:
        the range [m] of a w, from which on the contact shows."""
        many = 2 * MARCH_MEAN + 1
        smooth = np.convolve(np.pad(P, MARCH_MEAN, mode="edge"), np.full(many, 1 / many), "valid")
        place, force = float(np.interp(turn, t, x)), -min(float(np.min(smooth)), float(np.min(P)) / 2)
        load = float(np.interp(turn, t, smooth))
        lasts = float(np.ptp(t[np.abs(P) > force / MARCH_SEEN]))

        def start(ratio: float, time: float, share: float) -> dict[str, float]:
            def work(modulus: float) -> float:
                fast, rest = self.work(modulus, force), ratio * self.work(ratio * modulus, force)
                return float(fast ** (1 - share) * rest**share)

            zero = shows
            for _ in range(MARCH_ROUNDS):
                modulus = self.modulus(place - zero, load, work)
                zero = shows + ranged(work(modulus))
            return {"modulus": modulus, "ratio": ratio, "time": time * lasts, "w": work(modulus), "delta0": zero}

        return list(itertools.starmap(start, itertools.product(MARCH_RATIOS, MARCH_TIMES, MARCH_SHARES)))


@dataclass(eq=False)
class Secants:
    """Derivatives (readings, unknowns) of readings in units of their noise, ``kept`` from the last time: unknowns,
    readings there and derivatives."""

    kept: tuple[Array, Array, Array] | None = None

    def rates(self, readings: Callable[[Array], Array], x: Array, here: Array, steps: Array, own: int) -> Array:
        """Derivatives of ``readings`` at ``x``, where these are ``here``: by ``steps`` of the unknowns, or, where the
        last ones foretold the change from there, by these with what they missed. All but the first, ``own`` ones are
        nearly known: theirs are renewed never."""
        J, renewed = None, x.size
        if self.kept is not None and self.kept[2].shape == (here.size, x.size):
            x0, before, J = self.kept
            moved, missed = x - x0, here - before - J @ (x - x0)
            weighed = moved * np.sum(J**2, axis=0)
            length, least = float(weighed @ moved), SECANT_NOISE * math.sqrt(here.size)
            if length > 0:
                J = J + np.outer(missed, weighed / length)
            foretold = max(SECANT_FORETOLD * float(np.linalg.norm(here - before)), least)
            renewed = own if length > 0 and float(np.linalg.norm(missed)) > foretold else 0
        if J is None or renewed:
            J = np.zeros((here.size, x.size)) if J is None else J
            for i, size in enumerate(steps[:renewed].tolist()):
                for step in (size, -size):
                    moved = x.copy()
                    moved[i] += step
                    with contextlib.suppress(SolveError):
                        J[:, i] = (readings(moved) - here) / step
                        break
        self.kept = x.copy(), here, J
        return J
