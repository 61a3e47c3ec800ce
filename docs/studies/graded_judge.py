"""What a curve of finite range states on layers whose moduli vary over depth, against one differential equation per
wave number: states in contact and without, and every point at which contact is lost."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from graded_annulus import Contact, Stack, apart, kernel_of  # type: ignore[import-not-found]

from jkrcli.adhesion.curve import CONTROLS, CriticalPoint
from jkrcli.adhesion.finite_range import AttractedBody, FiniteRangeBody, FiniteRangeCurve, Range
from jkrcli.base.numerics import Array
from jkrcli.bodies.indenters import Paraboloid
from jkrcli.bodies.problem import (
    Elastic,
    Exponential,
    Graded,
    HalfSpace,
    Layer,
    Linear,
    Loading,
    Problem,
    Rigid,
    Specimen,
)
from jkrcli.methods.layered.solver import Layered

from .range_judge import ROUNDING, SMALL, Judged, stationary, work_within

H, RADIUS, ROWS = 1.0, 100.0, 30  # thickness and tip radius [m]: only their ratios matter; rows of a series
RATIO, WIDEST = (1.05, 20.0), 5.0  # of the moduli at both ends of a layer; a/h of the largest contact
PLACES = ("top", "below", "both")  # of the layers that are graded
ACCURACY = 1e-9  # of the reference: what other polynomials and cuts change
STATES, POINTS = 4, 5  # in contact and without, that are compared; around a point at which contact is lost
NEAR = 0.015  # of its radius, how far those lie from it
NARROW, WIDE = 0.02, 3.0  # of the annulus over the contact radius at pull-off, by JKR


@dataclass(frozen=True)
class GradedBody:
    """A random body, and the same for the reference; ``finest``: the least length over which it changes."""

    problem: Problem
    stack: Stack
    finest: float


def graded_body(rng: np.random.Generator) -> GradedBody:
    """A paraboloid on one or two layers of linear or exponential laws, bonded to a rigid base or a half-space."""
    place, nus = PLACES[rng.integers(3)], rng.uniform(0.0, 0.49, 3)
    layers, moduli, finest, E = list[Layer](), list[tuple[float, Any, float]](), H, 1.0
    for graded in ((True,), (False, True), (True, True))[PLACES.index(place)]:
        ratio = math.exp(rng.uniform(*np.log(RATIO)) * rng.choice([-1, 1])) if graded else 1.0
        nu = float(nus[len(layers)])
        if graded:
            law = (Linear, Exponential)[rng.integers(2)](E, ratio * E, H)
            layers.append(Layer(Graded(law, nu), H))
            moduli.append((H, law.at, nu))
            finest = min(finest, H / max(abs(ratio - 1), abs(1 / ratio - 1)))
        else:
            layers.append(Layer(Elastic(E, nu), H))
            moduli.append((H, partial(np.full_like, fill_value=E), nu))
        E *= ratio * float(np.exp(rng.uniform(-1, 1)))
    base = (E * float(np.exp(rng.uniform(-2, 2))), float(nus[2])) if rng.random() < 0.5 else None
    largest = H * math.exp(rng.uniform(math.log(0.3), math.log(WIDEST)))
    loading = Loading("radius", largest, ROWS)
    below = Rigid() if base is None else HalfSpace(Elastic(*base))
    return GradedBody(Problem(Paraboloid(RADIUS), Specimen(tuple(layers), below), loading), Stack(moduli, base), finest)


def graded_ranged(rng: np.random.Generator) -> list[Judged]:
    """P and delta of adhesion of a random finite range on a graded body at some states, and at pull-off under load,
    displacement, and by two springs, and the CPU seconds, as a ratio to ten."""
    body = graded_body(rng)
    problem, share = body.problem, rng.uniform(0.2, 0.7)
    series = Layered()(problem).series
    w = work_within(series, share)
    width = math.exp(rng.uniform(math.log(NARROW), math.log(WIDE))) * share * float(series.a[-1])
    law = Range.of(w, stress=math.sqrt(math.pi * problem.E_star * w / (4 * width)))
    stiffness = float(np.asarray(series.S)[len(series) // 2])
    controls = CONTROLS | {"spring": stiffness, "soft spring": stiffness / 30}
    begin = time.process_time()
    curve = FiniteRangeBody(problem, series, AttractedBody(problem)).curve(law, *controls.values())
    seconds = time.process_time() - begin
    judge = Reference(body, curve, kernel_of(body.stack, 1.2 * float(curve.c.max()), body.finest))
    found = [("seconds", seconds / 10, seconds, True), *judge.columns()]
    for control, each in controls.items():
        found += judge.point(control, each)
    return [(f"graded {name}", *rest) for name, *rest in found]  # type: ignore[misc]


@dataclass(frozen=True)
class Reference:
    """The states of a ``curve`` by the kernel ``tau`` of the reference."""

    body: GradedBody
    curve: FiniteRangeCurve
    tau: Any

    def held(self, a: float, c: float) -> tuple[float, float]:
        """delta [m] and P [N] at the contact radius ``a`` [m], sought from c near ``c``."""
        law, E_star = self.curve.law, self.body.stack.E_star
        _, delta, P = Contact(RADIUS, E_star, self.tau, a).closed(2 * law.stress / E_star, law.length, c)
        return delta, P

    def free(self, c: float) -> tuple[float, float]:
        """The same where nothing touches."""
        law, E_star = self.curve.law, self.body.stack.E_star
        found: tuple[float, float] = apart(RADIUS, E_star, self.tau, c, 2 * law.stress / E_star, law.length)
        return found

    def columns(self) -> list[Judged]:
        """delta and P at some of the points: at the worst."""
        curve, count = self.curve, self.curve.apart.c.size
        inner = np.linspace(count + 1, curve.a.size - 1, STATES).astype(int)
        rows = [*np.linspace(1, count - 1, STATES).astype(int), *inner] if count > STATES else [*inner]
        exact = np.array([
            self.held(curve.a[row], curve.c[row]) if curve.a[row] > 0 else self.free(curve.c[row]) for row in rows
        ]).T  # fmt: skip
        found = []
        for name, values in zip(("delta", "P"), exact, strict=True):
            unit = float(np.abs(getattr(curve, name)).max())
            room = ACCURACY * np.abs(values) + ROUNDING * unit
            off, stated = np.abs(getattr(curve, name)[rows] - values), curve.errors[name][rows]
            worst = int(np.argmax(np.maximum(off - room, 0) / stated))
            clear = bool(off[worst] > max(SMALL * abs(values[worst]), 3 * room[worst]))
            ratio = max(off[worst] - room[worst], 0.0) / stated[worst]
            found.append((name, float(ratio), float(stated[worst]) / max(abs(values[worst]), SMALL * unit), clear))
        return found

    def point(self, control: str, stiffness: float) -> list[Judged]:
        """P and delta where contact is lost, against the stationary state of a polynomial through exact ones."""
        curve, point = self.curve, self.curve.pull_off(stiffness)
        if not isinstance(point, CriticalPoint) or point.c is None:
            return []
        x: Array = NEAR * np.cos(np.pi * np.arange(POINTS) / (POINTS - 1))[::-1]
        if point.a > 0:
            near = curve.around(point.a * (1 + x))
            states = [self.held(a, c) for a, c in zip(point.a * (1 + x), near, strict=True)]
        else:
            states = [self.free(c) for c in point.c * (1 + x)]
        values = dict(zip(("delta", "P"), np.array(states).T, strict=True))
        unsure = {name: ACCURACY * float(np.abs(column).max()) for name, column in values.items()}
        return stationary(control, stiffness, x, values, unsure, point, curve.point_error(point, stiffness))
