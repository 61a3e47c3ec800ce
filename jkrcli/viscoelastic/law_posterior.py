"""What a force curve says of the law of relaxation. Where little relaxes within it, ratio and time are known together
only, on no ellipse; the loads, though, are nearly linear in r(t) itself: r = r_0 + sum of omega_k (exp(-q_k t) - 1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..base.numerics import SAME, TINY, Array
from ..bodies.problem import Modes
from ..measured.least_squares import State
from ..measured.parameters import Unknowns
from .adhesive_loads import LINE, ZONE, Adhering, is_time, likely_before
from .lockstep_march import Marched, Trial
from .timed_record import RelaxationSettings, relaxation_at

SPECTRUM = np.geomspace(0.3, 3000.0, 11)  # choice: rates q_k over the time in contact
SPECTRUM_STEP, LAW_STEP = 0.006, 1e-3  # choice: of r, and of parameters of laws, for differences
SPECTRUM_TIMES = np.geomspace(1e-4, 1.0, 50)  # choice: over the time in contact, at which r is told by these
OMEGA = np.linalg.pinv(np.expm1(-np.multiply.outer(SPECTRUM_TIMES, SPECTRUM)), rcond=1e-4).T  # of r at these
# choice: quantiles are then good to a tenth of a standard error
WALKERS, WALKED, BURNT, KEPT, TRIALS = 48, 330, 160, 600, 96
# choice: steps to valleys, and near them, where samples begin; ends of shares there; times over that in contact
SETTLING, SETTLING_NEAR, SHARE_ENDS, TIMES_TRIED = 15, 5, 1e-3, (0.01, 100.0)
UNKNOWN = 10.0  # choice: of logs, beyond which samples say no more
STRETCH = 2.0  # theory: of Goodman and Weare's moves (Comm. App. Math. Comp. Sci. 5 (2010) 65)
SEED = 1  # choice: the same samples every day
MARCH_ERROR = 0.5  # choice: of what narrower zones change, what they may still err by
ONSET, APART_TIMES = 0.01, 4.0  # choice: of power laws; from time to time of a series


@dataclass(frozen=True, eq=False)
class Nearby:
    """What the record says near the unknowns ``x``, by the ``marches`` of these with the ``modes``, of steps of those
    that are not of the law and of r(t) at each rate; ``ended``: whether ``x`` is the likeliest."""

    model: Adhering
    x: Array
    modes: Modes
    marches: Sequence[Marched]
    ended: bool = False

    @classmethod
    def of(cls, model: Adhering, x: Array) -> Nearby:
        trial, added, names = model.trial(x), list[Trial](), cls._others(model)
        modes, step = trial.modes, cls._step(trial.modes)
        for q in (SPECTRUM / model.cycle.lasting).tolist():
            more = Modes(modes.relaxed - step, np.append(modes.weights, step), np.append(modes.rates, q))
            added.append(replace(trial, modes=more))
        trials = [trial, *map(model.trial, model.moved(x, names)), *added]
        return cls(model, x, modes, model.march(trials, [0] * len(trials)))

    @staticmethod
    def _step(modes: Modes) -> float:
        return SPECTRUM_STEP if modes.relaxed > 2 * SPECTRUM_STEP else -SPECTRUM_STEP

    def by_law(self, settings: RelaxationSettings) -> Nearby:
        """The same for the parameters of another law that is not far."""
        model, cycle = self.model, self.model.cycle
        values = model.unknowns.values(self.x)
        unknowns = Unknowns(settings.parameters, model.unknowns.units)
        law = law_near(settings, values["ratio"], values["time"], cycle.lasting)
        at_once = values["modulus"] * law.pop("modulus", 1.0)
        x = unknowns.at({**values, **law, "modulus": at_once, **settings.fixed})
        return replace(self, model=replace(model, settings=settings, unknowns=unknowns), x=x)

    @staticmethod
    def _others(model: Adhering) -> list[str]:
        """The unknowns that are not of the law and move the contact."""
        return [name for name in model.unknowns.names
                if name not in LINE and likely_before(name, model.cycle.lasting) is None]  # fmt: skip

    @property
    def here(self) -> Marched:
        return self.marches[0]

    @cached_property
    def own(self) -> Array:
        """Mask of the unknowns of the law."""
        return np.array(
            [likely_before(name, self.model.cycle.lasting) is not None for name in self.model.unknowns.names]
        )

    @property
    def names(self) -> list[str]:
        """Of the unknowns of the law."""
        return [name for name, own in zip(self.model.unknowns.names, self.own, strict=True) if own]

    @cached_property
    def by_r(self) -> Array:
        """Derivatives of the residuals by the omega_k, (rows, rates)."""
        step, there = self._step(self.modes), self.marches[1 + len(self._others(self.model)) :]
        loads = self.model.loads(self.x, self.here)
        return np.stack([self.model.change(self.here, loads, self.x, one) for one in there], axis=1) / step

    @cached_property
    def state(self) -> State:
        """Residuals at ``x`` and their derivatives, by the law through r(t)."""
        others, law, unit = self._others(self.model), self.x[self.own], np.eye(int(self.own.sum()))
        columns = self.model.rates(self.x, self.here, others, self.marches[1 : 1 + len(others)])
        for name, direction in zip(self.names, unit, strict=True):
            ends = law + LAW_STEP * np.multiply.outer([1.0, -1.0], direction)
            by = np.diff(self.spectrum(ends), axis=0)[0] / (-2 * LAW_STEP)
            columns[name] = self.by_r @ by
            if "modulus" in columns:
                stiffer = math.log(np.divide(*self.r(ends, np.zeros(1))[:, 0])) / (2 * LAW_STEP)
                columns[name] = columns[name] + stiffer * columns["modulus"]
        return self.model.state(self.x, self.here, columns)

    @property
    def cost(self) -> float:
        return self.state.cost

    @property
    def scatter(self) -> float:
        """Standard deviation of the residuals of the rows over the noise they are weighed by."""
        off = self.state.residuals[: self.model.cycle.t.size]
        return math.sqrt(float(off @ off) / max(int(np.count_nonzero(off)) - self.x.size, 1))

    def r(self, law: Array, t: Array) -> Array:
        """r at the times ``t`` [s] (n, times) of laws (n, parameters)."""
        settings = self.model.settings
        own = {name: np.exp(one) if is_time(name) else one for name, one in zip(self.names, law.T, strict=True)}
        return np.broadcast_to(relaxation_at(t, settings.law, {**settings.fixed, **own}), (len(law), t.size))

    def relaxed(self, law: Array) -> Array:
        """r(t)/r(0) of laws (n, parameters) at ``SPECTRUM_TIMES``, (n, times)."""
        r = self.r(law, np.append(0.0, SPECTRUM_TIMES) * self.model.cycle.lasting)
        return r[:, 1:] / r[:, :1]

    def spectrum(self, law: Array) -> Array:
        """The weights of exp(-q_k t) - 1 in r(t)/r(0) - 1 of laws (n, parameters), (n, rates)."""
        return (self.relaxed(law) - 1) @ OMEGA

    @cached_property
    def own_spectrum(self) -> Array:
        """That of the ``modes``."""
        t = SPECTRUM_TIMES * self.model.cycle.lasting
        return np.expm1(-np.multiply.outer(t, self.modes.rates)) @ self.modes.weights @ OMEGA

    def stiffer(self, law: Array) -> Array:
        """Log of r(0) of laws (n, parameters) over that of ``x``, (n,)."""
        zero = np.zeros(1)
        return np.log(self.r(law, zero) / self.r(self.x[self.own][None], zero))[:, 0]

    def moves(self, x: Array) -> float:
        """By how many standard errors of the rows the loads at ``x`` differ from those here, squared."""
        law, by = x[self.own][None], x - self.x
        if "modulus" in self.model.unknowns.names:
            i = self.model.unknowns.names.index("modulus")
            by[i] = math.expm1(by[i] + self.stiffer(law)[0])
        stiffer = 1 + (by[i] if "modulus" in self.model.unknowns.names else 0.0)
        omega = stiffer * (self.spectrum(law)[0] - self.own_spectrum)
        moved = self.state.jacobian[: len(self.by_r), ~self.own] @ by[~self.own] + self.by_r @ omega
        return float(moved @ moved)


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is likely of the law's parameters by what the record says ``near`` some unknowns, and of the others given
    these. Loads are linear in E(t), (1 + mu) r(t) + sum omega_k (exp(-q_k t) - 1) over the modulus at t = 0: minus
    twice the log is |``left`` + ``stiff`` mu + ``matrix`` omega|^2, least in mu, and the others, all but that
    modulus at t = 0, are ``mean`` + ``by`` (mu, omega) with the Cholesky root ``spread`` of their covariance."""

    near: Nearby
    others: Array
    left: Array
    stiff: Array
    matrix: Array
    mean: Array
    by: Array
    spread: Array
    within: float

    @classmethod
    def of(cls, near: Nearby, variance: float, within: float = math.inf, held: float = 1.0) -> Posterior:
        """Of residuals of the ``variance``, over the noise; ``within``: how far off logs of the others and of r(t) are
        likely, of the cohesive stress that times ``held``."""
        J, off, rows = near.state.jacobian, near.state.residuals, len(near.by_r)
        modulus = np.array([name == "modulus" for name in near.model.unknowns.names])
        logs = np.array([one.kind == "log" for one in near.model.unknowns.free])
        others = ~near.own & ~modulus
        far = logs / within / np.where(np.isin(near.model.unknowns.names, ZONE), held, 1.0)
        # in the end what marches err by, another in each half of each piece of the program, are unknowns too
        errs = near.model.march_errors(near.here, near.x) * math.isinf(within)
        m, p, n = errs.shape[1], int(others.sum()), off.size
        every = np.zeros((n + m + p + 1, p + m + near.by_r.shape[1] + 2))
        every[:n, :p], every[:n, p + m], every[:n, -1] = J[:, others], J[:, modulus].sum(axis=1), off
        every[: len(errs), p : p + m], every[:rows, p + m + 1 : -1] = errs, near.by_r
        every[rows : rows + int(near.own.sum())] = 0.0  # what is likely of the law is told apart
        every[:n] /= math.sqrt(variance)
        every[n : n + m, p : p + m] = np.eye(m)
        every[n + m : -1, :p], every[-1, p + m] = np.diag(far[others]), modulus @ far
        Q, R = np.linalg.qr(every[:, : p + m])
        on = Q.T @ every[:, p + m :]
        seen = np.linalg.qr(every[:, p + m :] - Q @ on)[1]
        back = np.linalg.pinv(R)[:p]
        spread, found = back @ back.T, -back @ on
        root = np.linalg.cholesky(spread + 1e-12 * np.diag(np.diag(spread)))
        return cls(near, others, seen[:, -1], seen[:, 0], seen[:, 1:-1], found[:, -1], found[:, :-1], root, within)

    def told(self, law: Array) -> tuple[Array, Array, Array]:
        """What is left of all rows and of what is likely before, by parameters ``law`` (n, parameters), as residuals
        (n, rows), with the likeliest mu (n,), and its standard deviation."""
        relaxed = self.near.relaxed(law)
        changed = ((relaxed - 1) @ OMEGA - self.near.own_spectrum) @ self.matrix.T
        off = self.left + changed
        mu, known = np.zeros(len(law)), np.zeros(len(law))
        if self.stiff.any():
            by = self.stiff + changed
            known = 1 / np.maximum(np.sqrt(np.sum(by**2, axis=1)), TINY)
            mu = np.maximum(-np.sum(by * off, axis=1) * known**2, SAME - 1)
            off = off + mu[:, None] * by
        likely = np.array([likely_before(name, self.near.model.cycle.lasting) for name in self.near.names]).reshape(
            -1, 2
        )
        every = [off, (law - likely[:, 0]) / likely[:, 1]]
        if math.isfinite(self.within):
            further = np.log(np.maximum(relaxed, TINY) / self.near.relaxed(self.near.x[self.near.own][None]))
            every.append(further / (self.within * math.sqrt(SPECTRUM_TIMES.size)))
        return np.concatenate(every, axis=1), mu, known

    def off(self, law: Array) -> Array:
        """The residuals of ``told``."""
        return self.told(law)[0]

    def log(self, law: Array) -> Array:
        """Logs of what parameters ``law`` (n, parameters) are likely."""
        shares = law[:, [not is_time(name) for name in self.near.names]]
        weights = law[:, [name.startswith("weight") for name in self.near.names]]
        possible = ((shares > 0) & (shares < 1)).all(axis=1) & (weights.sum(axis=1) < 1)
        return np.where(possible, -np.sum(self.off(law) ** 2, axis=1) / 2, -np.inf)

    def samples(self, shifts: Array) -> tuple[Array, Array]:
        """A point in the middle of what is likely, and samples of all unknowns (n, unknowns); ``shifts``: what narrower
        zones moved them, of which a part may be left over, and the ways to valleys that are as likely."""
        rng = np.random.default_rng(SEED)
        law = np.tile(self.near.x[self.near.own], (KEPT, 1))
        if law.size:
            law = rng.choice(self._walked(rng), KEPT, replace=False)
        found = self._whole(law, rng.standard_normal(KEPT))
        found[:, self.others] += rng.standard_normal((KEPT, len(self.mean))) @ self.spread.T
        found += MARCH_ERROR * rng.standard_normal((KEPT, len(shifts))) @ shifts
        shares = [i for i, name in enumerate(self.near.model.unknowns.names) if self.near.own[i] and not is_time(name)]
        found[:, shares] = np.clip(found[:, shares], SAME, 1 - SAME)
        logs = np.array([one.kind == "log" for one in self.near.model.unknowns.free])
        # of the samples of the law that whose r(t) is nearest to the medians, with the most likely others
        r = np.log(np.maximum(self.near.r(law, SPECTRUM_TIMES * self.near.model.cycle.lasting), TINY))
        off = (r - np.median(r, axis=0)) / np.maximum(np.std(r, axis=0), TINY)
        nearest = int(np.argmin(np.sum(off**2, axis=1)))
        middle: Array = self._whole(law[nearest : nearest + 1])[0]
        return middle, np.where(logs, np.clip(found, middle - UNKNOWN, middle + UNKNOWN), found)

    def _whole(self, law: Array, errors: Array | float = 0.0) -> Array:
        """All unknowns (n, unknowns) with those of the ``law`` and the most likely of the others; of a modulus at t = 0
        that is so many standard ``errors`` more."""
        _, mu, known = self.told(law)
        mu = np.maximum(mu + errors * known, SAME - 1)
        omega = (1 + mu)[:, None] * (self.near.spectrum(law) - self.near.own_spectrum)
        found = np.tile(self.near.x, (len(law), 1))
        found[:, self.near.own] = law
        found[:, self.others] += self.mean + np.column_stack([mu, omega]) @ self.by.T
        if "modulus" in self.near.model.unknowns.names:
            i = self.near.model.unknowns.names.index("modulus")
            found[:, i] += np.log1p(mu) - self.near.stiffer(law)
        return found

    def likeliest(self) -> Array:
        """The unknowns with the likeliest law."""
        law = self._settled(self._about(np.random.default_rng(SEED)))
        return self._whole(law[:1])[0]

    def _about(self, rng: np.random.Generator) -> Array:
        """Parameters of the law: its own, first, others near to it, and as many anywhere."""
        here, lasting = np.tile(self.near.x[self.near.own], (TRIALS, 1)), self.near.model.cycle.lasting
        for i, name in enumerate(self.near.names):
            width = 10 ** rng.uniform(-3, 0.3, TRIALS - 1) * (2.0 if is_time(name) else 0.3)
            here[1:, i] += rng.normal(0, 1, TRIALS - 1) * width
            low, high = np.log(TIMES_TRIED).tolist()
            anywhere = math.log(lasting) + rng.uniform(low, high, TRIALS)
            far = anywhere if is_time(name) else rng.random(TRIALS)
            here[TRIALS // 2 :, i] = far[TRIALS // 2 :]
            if not is_time(name):
                here[:, i] = np.clip(here[:, i], SHARE_ENDS, 1 - SHARE_ENDS)
        return here

    def _settled(self, law: Array, steps_of: int = SETTLING) -> Array:
        """Each of many parameters ``law`` by steps of Levenberg and Marquardt in the valley next to it, the likeliest
        first."""
        d, log, damping = law.shape[1], self.log(law), np.full(len(law), 1e-2)
        steps = np.array([0.01 if is_time(name) else 1e-3 for name in self.near.names])
        shares = np.array([not is_time(name) for name in self.near.names], dtype=bool)
        for _ in range(steps_of if d else 0):
            off = self.off(law)
            J = np.stack([(self.off(law + step) - off) / step.sum() for step in np.diag(steps)], axis=2)
            A = np.einsum("nri,nrj->nij", J, J)
            A += damping[:, None, None] * (A * np.eye(d)) + TINY * np.eye(d)
            moved = -np.linalg.solve(A, np.einsum("nri,nr->ni", J, off)[..., None])[..., 0]
            there = law + np.clip(moved, -50 * steps, 50 * steps)
            there = np.where(shares, np.clip(there, SHARE_ENDS, 1 - SHARE_ENDS), there)
            better = self.log(there) > log
            law = np.where(better[:, None], there, law)
            log, damping = self.log(law), damping * np.where(better, 0.3, 10.0)
        return law[np.argsort(-log)]

    def _walked(self, rng: np.random.Generator) -> Array:
        """Samples of the law's parameters, (n, parameters), by walks over the logs of the slopes weight/time, by which
        laws of times beyond the record are alike, and of the times."""
        names, power = self.near.names, self.near.model.settings.law == "power"
        exponentials = not power and [*map(is_time, names)] == [False, True] * (len(names) // 2)
        turned = -1.0 if self.near.names[0] == "ratio" else 1.0  # the weight is 1 - ratio

        def slopes(law: Array) -> Array:
            if not exponentials:
                return law
            here = law.copy()
            here[:, ::2] = np.log(law[:, ::2] if turned > 0 else 1 - law[:, ::2]) - law[:, 1::2]
            return here

        def laws(here: Array) -> Array:
            if not exponentials:
                return here
            law = here.copy()
            weights = np.exp(np.minimum(here[:, ::2] + here[:, 1::2], 1.0))
            law[:, ::2] = weights if turned > 0 else 1 - weights
            return law

        def logs(here: Array) -> Array:
            return self.log(laws(here)) + (np.sum(here, axis=1) if exponentials else 0.0)

        near = self._settled(self._about(rng), SETTLING_NEAR)
        here = slopes(near[:WALKERS])
        log, kept = logs(here), []
        halves, d = np.arange(WALKERS) < WALKERS // 2, here.shape[1]
        for step in range(WALKED):
            for some in (halves, ~halves):
                stretch = (1 + (STRETCH - 1) * rng.random(WALKERS // 2)) ** 2 / STRETCH
                other = rng.choice(here[~some], WALKERS // 2)
                tried = other + stretch[:, None] * (here[some] - other)
                there = logs(tried)
                takes = np.log(rng.random(WALKERS // 2)) < (d - 1) * np.log(stretch) + there - log[some]
                here[some] = np.where(takes[:, None], tried, here[some])
                log[some] = np.where(takes, there, log[some])
            if step >= BURNT:
                kept.append(laws(here))
        law, terms = np.concatenate(kept), self.near.model.settings.terms
        if self.near.model.settings.law != "prony" or len(names) < 2 * terms:
            return law

        # the terms of Prony's series by their times, where none of them is fixed
        pairs = law.reshape(-1, terms, 2)
        order = np.argsort(pairs[..., 1], axis=1)
        return np.take_along_axis(pairs, order[..., None], axis=1).reshape(law.shape)


def law_near(settings: RelaxationSettings, ratio: float, time: float, lasting: float) -> dict[str, float]:
    """Parameters of a law near a standard solid of ``ratio`` and ``time`` [s] in a contact ``lasting`` so long [s]; the
    "modulus" of a power law is over that at t = 0."""
    if settings.law == "power":
        left, onset = ratio + (1 - ratio) * math.exp(-lasting / time), ONSET * lasting
        exponent = min(max(-math.log(left) / math.log1p(lasting / onset), 0.01), 0.9)
        return {"onset": onset, "exponent": exponent, "modulus": (settings.fixed["time"] / onset) ** -exponent}
    n = settings.terms
    weights = {f"weight{i + 1}": max((1 - ratio) / n, 0.01) for i in range(n)}
    return weights | {f"time{i + 1}": time * APART_TIMES ** (i - (n - 1) / 2) for i in range(n)}
