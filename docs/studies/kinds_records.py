"""Make force curves of 26 kinds, and clean ones, by mechanics that share no code with what reads them.

A rigid sphere or paraboloid, each exact, on an elastic half-space or on a layer bonded to a rigid base. The layer's
surface compliance is 2 (1 - m(kh))/(E* k), m -> 0 for k -> inf; with the transformed pressure E*/2 int_0^a phi(t)
cos(kt) dt the contact is a Fredholm equation of the second kind,

    phi(x) - 2/pi int_0^a K(x, t) phi(t) dt = 2/pi (delta - g(x)),    K(x, t) = int_0^inf m(kh) cos(kx) cos(kt) dk,

with the tip's Abel image g: t^2/R of a paraboloid, t artanh(t/R) of a sphere. The load is pi E* int phi, the energy
release rate at the edge G = pi E* phi(a)^2/(8 a). An advancing edge has G = w_approach, a receding one G = w, and after
the turn the edge rests until G has come from the one to the other. Base position z = delta + F/k of a cantilever; it
jumps where dz/da = 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

Array = NDArray[np.float64]
Rng = np.random.Generator
RADII = 6000  # of contact on a branch, by equal ratios
LEAST = 1e-3  # of the largest contact radius, where branches begin


# --------------------------------------------------------------------------------------------------
# A tip pressed into a half-space or a bonded layer.


def lack(x: Array, nu: float) -> Array:
    """Return m(kh), what a bonded layer's compliance lacks of the half-space's, over ``x`` = kh."""
    kappa, q = 3 - 4 * nu, np.exp(-2 * x)
    more = 4 * x**2 + kappa**2 + 1
    lacking: Array = q * (2 * kappa * q + more + 4 * x) / (kappa * (1 + q**2) + more * q)
    return lacking


@dataclass(frozen=True)
class Tip:
    """A rigid sphere, or paraboloid, of radius ``R`` [m]."""

    R: float
    sphere: bool

    def image(self, t: Array) -> Array:
        """Return the Abel image [m] of the profile: the depth at contact radius ``t`` on a half-space."""
        return t * np.arctanh(t / self.R) if self.sphere else t**2 / self.R

    def load(self, a: Array) -> Array:
        """Return the load over E* [m^2] at contact radii on a half-space."""
        R = self.R
        return (a**2 + R**2) * np.arctanh(a / R) - a * R if self.sphere else 4 * a**3 / (3 * R)


def punched(tip: Tip, h: float, nu: float, a: float, nodes: int = 48) -> tuple[float, float, float, float]:
    """Return the depth [m], the load over E* [m^2], the stiffness over E* [m] and the flat punch's phi(a) of a layer of
    thickness ``h`` [m] at contact radius ``a`` [m]."""
    x, dx = np.polynomial.legendre.leggauss(nodes)
    t, dt = a * (x + 1) / 2, a * dx / 2
    y, dy = np.polynomial.legendre.leggauss(12)
    panels = np.arange(int(25 * max(1.0, a / h)) + 1)[:, None] * min(1.0, h / a)
    k, dk = (panels + min(1.0, h / a) * (y + 1) / 2).ravel(), np.tile(min(1.0, h / a) * dy / 2, panels.size)
    waves = np.cos(np.outer(np.append(t, a), k / h))
    kernel = 2 / math.pi * (waves * (lack(k, nu) * dk / h)) @ waves.T
    ends = np.append(t, a)
    known = 2 / math.pi * np.stack([np.ones(ends.size), tip.image(ends)], axis=1)
    phi = np.linalg.solve(np.eye(nodes) - kernel[:-1, :-1] * dt, known[:-1])
    flat, shaped = known[-1] + (kernel[-1, :-1] * dt) @ phi  # at the edge
    depth = shaped / flat
    return depth, math.pi * float(dt @ (depth * phi[:, 0] - phi[:, 1])), math.pi * float(dt @ phi[:, 0]), float(flat)


@dataclass(frozen=True, eq=False)
class Contact:
    """A tip on a half-space, or on a layer of thickness ``h`` [m], up to contact radius ``largest`` [m]."""

    tip: Tip
    h: float | None
    nu: float
    largest: float

    @cached_property
    def a(self) -> Array:
        return np.geomspace(LEAST, 1.0, RADII) * self.largest

    @cached_property
    def functions(self) -> tuple[Array, Array, Array, Array]:
        """Depth [m], load over E* [m^2], stiffness over E* [m] and phi(a) of the flat punch, without adhesion."""
        a = self.a
        plain = self.tip.image(a), self.tip.load(a), 2 * a, np.full(a.size, 2 / math.pi)
        if self.h is None:
            return plain
        at = np.geomspace(LEAST, 1.0, 60) * self.largest
        solved = np.array([punched(self.tip, self.h, self.nu, one) for one in at]).T
        own = self.tip.image(at), self.tip.load(at), 2 * at, np.full(at.size, 2 / math.pi)
        ratio = CubicSpline(np.log(at), np.log(solved / np.array(own)), axis=1)(np.log(a))
        depth, load, stiffness, edge = np.array(plain) * np.exp(ratio)
        return depth, load, stiffness, edge

    def adhesive(self, E: float, w: float) -> tuple[Array, Array]:
        """Return displacement [m] and load [N] over the radii where G = ``w`` at the edge."""
        depth, load, stiffness, edge = self.functions
        lift = np.sqrt(8 * self.a * w / (math.pi * E)) / edge
        return depth - lift, E * (load - stiffness * lift)


# --------------------------------------------------------------------------------------------------
# A specimen, a tip and a cantilever, and their way through a record.


@dataclass(frozen=True, eq=False)
class Setup:
    """What a record is made of [SI]: works of adhesion ``w`` and ``w_in`` of approach, stiffness ``k`` of the
    cantilever, ``noise`` [N] of a row, ``rows`` of a direction, ``far``: free way over the way in contact."""

    contact: Contact
    E: float
    w: float
    w_in: float
    k: float
    noise: float
    rows: int
    far: float

    @classmethod
    def drawn(
        cls, rng: Rng, layer: bool = False, pull: tuple[float, float] = (0.02, 0.5),
        ratio: tuple[float, float] = (0.1, 10.0), noise: tuple[float, float] = (1e-3, 3e-2),
        approach: tuple[float, float] = (0.3, 1.0),
    ) -> Setup:  # fmt: skip
        """Draw one whose pull-off force over the largest load, contact's stiffness over the cantilever's, noise over
        the pull-off force and w of approach over w lie in ranges."""
        tip = Tip(_between(rng, 5e-7, 2e-5), bool(rng.random() < 0.5))
        E, largest = _between(rng, 1e3, 5e6), tip.R * rng.uniform(0.06, 0.3)
        h, nu = (largest / _between(rng, 0.3, 2.0), float(rng.choice([0.3, 0.4, 0.45, 0.5]))) if layer else (None, 0.5)
        contact = Contact(tip, h, nu, largest)
        share, inward = _between(rng, *pull), rng.uniform(*approach)

        def excess(log_w: float) -> float:
            w = math.exp(log_w)
            return -float(contact.adhesive(E, w)[1].min()) - share * float(contact.adhesive(E, inward * w)[1][-1])

        expected = math.log(share * E * contact.functions[1][-1] / (1.5 * math.pi * tip.R))
        w = math.exp(brentq(excess, expected - 6, expected + 3, xtol=1e-9))
        k = E * float(contact.functions[2][-1]) / _between(rng, *ratio)
        force = -float(contact.adhesive(E, w)[1].min())
        return cls(contact, E, w, inward * w, k, force * _between(rng, *noise), round(_between(rng, 300, 3000)),
                   rng.uniform(0.4, 2.0))  # fmt: skip

    @cached_property
    def force(self) -> float:
        """Pull-off force [N] under dead load."""
        return -float(self.contact.adhesive(self.E, self.w)[1].min())

    @cached_property
    def top(self) -> float:
        """Load [N] at the turn."""
        return float(self.contact.adhesive(self.E, self.w_in)[1][-1])

    @property
    def words(self) -> str:
        """What is drawn, in a line."""
        tip, body = "sphere" if self.contact.tip.sphere else "paraboloid", "half-space"
        if self.contact.h is not None:
            body = f"layer of nu {self.contact.nu:g}, a/h to {self.contact.largest / self.contact.h:.2g}"
        ratio = self.E * float(self.contact.functions[2][-1]) / self.k
        return (f"{tip} on {body}: pull-off {self.force / self.top:.2g} of load, contact {ratio:.2g} times as stiff "
                f"as lever, noise {self.noise / self.force:.2g} of the pull-off, {self.rows} rows")  # fmt: skip

    @property
    def truth(self) -> dict[str, float]:
        return {"E_star": self.E, "w": self.w, "w_approach": self.w_in}


@dataclass(frozen=True)
class Reaching:
    """A force of ``size`` [N] at touch, negative where it attracts, that falls over ``reach`` [m] of the gap by an
    exponential, or by the inverse square of the distance; in contact it ``stays`` or is gone."""

    size: float = 0.0
    reach: float = 1.0
    power: bool = False
    stays: bool = True

    def over(self, gap: Array) -> Array:
        x = gap / self.reach
        return self.size * ((1 + x) ** -2.0 if self.power else np.exp(-x))

    @property
    def in_contact(self) -> float:
        return self.size if self.stays else 0.0


@dataclass(frozen=True)
class Course:
    """What happens in contact beside elasticity: a ``dent`` [m] that remains, the ``relaxed`` share of the load in a
    hold of ``held`` times the rows of a direction, and a second contact, a spring [N/m] that is stretched from zero
    displacement on and lets go at base position ``until`` [m]."""

    dent: float = 0.0
    relaxed: float = 0.0
    held: float = 0.0
    spring: float = 0.0
    until: float = 0.0


@dataclass(frozen=True, eq=False)
class Way:
    """Rows of a record in time: positions ``z`` [m] of the base, forces ``F`` [N]; ``turn``: the first row of the
    retraction; ``joined``: the first in contact; ``lost``: the first after pull-off."""

    z: Array
    F: Array
    joined: int
    turn: int
    lost: int

    @property
    def span(self) -> float:
        return float(np.ptp(self.z))

    @property
    def share(self) -> Array:
        """Positions from 0 to 1."""
        share: Array = (self.z - self.z.min()) / self.span
        return share

    @property
    def free(self) -> int:
        """Rows after pull-off."""
        return self.z.size - self.lost


def _between(rng: Rng, low: float, high: float) -> float:
    """Draw by equal ratios."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _advancing(at: Setup, reaching: Reaching, course: Course) -> tuple[Array, Array]:
    """Return positions and forces of the approach in contact, from the fold of the cantilever on."""
    delta, P = at.contact.adhesive(at.E, at.w_in)
    F = P + reaching.in_contact
    z = delta + course.dent * (at.contact.a / at.contact.largest) ** 2 + F / at.k
    fold = int(np.argmin(z))
    return z[fold:], F[fold:]


def _receding(at: Setup, reaching: Reaching, course: Course) -> tuple[Array, Array]:
    """Return positions and forces of the retraction in contact: an edge at rest above one that recedes, down to the
    fold of the cantilever."""
    start, load = (float(values[-1]) for values in at.contact.adhesive(at.E, at.w_in))
    delta, P = at.contact.adhesive(at.E, at.w)
    S = at.E * float(at.contact.functions[2][-1])

    # At rest P = P_m + S (delta - delta_m), down to G = w; a relaxation at constant z shifts the surface.
    lost = course.relaxed * load
    shift = course.dent + lost * (1 / S + 1 / at.k)
    resting = np.linspace(float(delta[-1]), start - lost / S, 2000)[1:]
    delta, P = np.append(delta, resting), np.append(P, load + S * (resting - start))

    F = P + reaching.in_contact + course.spring * np.minimum(delta, 0.0)
    z = delta + shift + F / at.k
    fold = int(np.argmin(z))
    return z[fold:], F[fold:]


def _free(at: Setup, reaching: Reaching) -> tuple[Array, Array]:
    """Return positions and forces out of contact, up to where the gap closes or the cantilever jumps to contact."""
    if reaching.size == 0:
        return np.array([-1.0, 0.0]), np.zeros(2)
    gap = np.append(np.linspace(0, 6, 20000), np.geomspace(6.001, 1e6, 6000)) * reaching.reach
    F = reaching.over(gap)
    z = -gap + F / at.k
    fold = int(np.argmax(z))
    return z[fold:][::-1], F[fold:][::-1]


def way(at: Setup, reaching: Reaching = Reaching(), course: Course = Course()) -> Way:
    """Follow a whole record at even steps of z, without noise."""
    (z_in, F_in), (z_out, F_out), (z_free, F_free) = (
        _advancing(at, reaching, course), _receding(at, reaching, course), _free(at, reaching)
    )  # fmt: skip
    top, touch, loss = float(z_in[-1]), float(z_free[-1]), float(z_out[0])
    lowest = min(float(z_in[0]), loss)
    z = np.linspace(lowest - at.far * (top - lowest), top, at.rows)

    into = np.where(z >= touch, np.interp(z, z_in, F_in), np.interp(z, z_free, F_free))
    out = np.where(z >= loss, np.interp(z, z_out, F_out), np.interp(z, z_free, F_free))
    if course.spring:
        stretched = (z < loss) & (z >= course.until)
        out[stretched] += z[stretched] / (1 / course.spring + 1 / at.k)
    count = round(course.held * at.rows)
    hold = into[-1] - course.relaxed * at.top * (-np.expm1(-5 * np.arange(1, count + 1) / max(count, 1)))
    F = np.concatenate([into, hold, out[::-1]])
    turn = at.rows + count
    return Way(np.concatenate([z, np.full(count, top), z[::-1]]), F, int(np.argmax(z >= touch)), turn,
               turn + int(np.count_nonzero(z >= loss)))  # fmt: skip


# --------------------------------------------------------------------------------------------------
# Records as they are written.


@dataclass(frozen=True, eq=False)
class Made:
    """A record: columns ``z`` [m] and ``F`` [N] as an instrument writes them, the ``truth`` of what it determines, by
    name, and the ``options`` of the fit."""

    at: Setup
    z: Array
    F: Array
    truth: dict[str, float]
    options: dict[str, str] = field(default_factory=dict)

    def write(self, file: Path) -> None:
        rows = [f"{1e9 * z:.9g}\t{1e9 * F:.9g}" for z, F in zip(self.z, self.F, strict=True)]
        head = ["# instrument: force microscope", f"# spring constant: {self.at.k:.9g} N/m", "Z (nm)\tForce (nN)"]
        file.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")

    @property
    def typed(self) -> list[str]:
        """What a user types after ``jkr fit FILE``."""
        contact = self.at.contact
        words = ["--shape", "sphere" if contact.tip.sphere else "paraboloid", "--radius", f"{contact.tip.R:.12g} m",
                 "--nu", f"{contact.nu:g}"]  # fmt: skip
        words += [] if contact.h is None else ["--thickness", f"{contact.h:.12g} m"]
        return words + [word for name, value in self.options.items() for word in (f"--{name}", value)]


def recorded(rng: Rng, at: Setup, way: Way, F: Array | None = None, z: Array | None = None, without: str = "") -> Made:
    """Write a record with white noise, an offset, a tilt in every second one and positions from an arbitrary zero;
    ``without``: names, by blanks, of what it does not determine."""
    z, F = way.z if z is None else z, way.F if F is None else F
    tilt = rng.uniform(-0.1, 0.1) * (rng.random() < 0.5)
    F = F + at.force * (rng.uniform(-3, 3) + tilt * (z - z.min()) / np.ptp(z)) + at.noise * rng.normal(size=z.size)
    truth = {name: value for name, value in at.truth.items() if name not in without.split()}
    return Made(at, z + rng.uniform(-5e-6, 5e-6), F, truth)


# ---------------------------------------------------------------------- forces beside contact, added to a way
Force = Callable[[Rng, Setup, Way], Array]


def tether_force(rng: Rng, at: Setup, way: Way) -> Array:
    """Hold a level of 5 to 20 % of the pull-off force over half of the free way, then let go."""
    rows = np.arange(way.z.size) - way.lost
    return -np.where((rows >= 0) & (rows < way.free // 2), at.force * rng.uniform(0.05, 0.2), 0.0)


def tethers_force(rng: Rng, at: Setup, way: Way) -> Array:
    """Hold by two to four that are stretched or slacken on the way and let go one by one."""
    rows, F = np.arange(way.z.size) - way.lost, np.zeros(way.z.size)
    count = int(rng.integers(2, 5))
    for _ in range(count):
        length = rng.uniform(0.1, 0.85) * way.free
        size, slope = at.force * rng.uniform(0.05, 0.25) / math.sqrt(count), rng.uniform(-0.5, 0.8)
        F -= np.where((rows >= 0) & (rows < length), size * (1 + slope * (rows / length - 0.5)), 0.0)
    return F


def quadratic_force(rng: Rng, at: Setup, way: Way) -> Array:
    """Bend the base line by 3 % of the largest load over the whole way, either way."""
    return rng.choice([-1, 1]) * 0.03 * at.top * way.share**2


def wave_force(rng: Rng, at: Setup, way: Way) -> Array:
    """Interfere: a sine of 1 to 15 % of the pull-off force, 2 to 8 periods over the way."""
    phase = 2 * math.pi * (rng.uniform(2, 8) * way.share + rng.random())
    return at.force * _between(rng, 0.01, 0.15) * np.sin(phase)


def drag_force(rng: Rng, at: Setup, way: Way) -> Array:
    """Drag by 2 to 20 % of the pull-off force against the motion, none at rest."""
    return at.force * _between(rng, 0.02, 0.2) * np.sign(np.gradient(way.z))


def decay_force(rng: Rng, at: Setup, way: Way) -> Array:
    """Drift from the start by 10 to 100 % of the pull-off force, decaying over 5 to 40 % of the time."""
    t = np.arange(way.z.size) / way.z.size
    return rng.choice([-1, 1]) * at.force * _between(rng, 0.1, 1.0) * np.exp(-t / rng.uniform(0.05, 0.4))


def _reaching(rng: Rng, at: Setup, kind: str) -> Reaching:
    """Draw a charge, a tail that ends at touch, or a brush: 3 to 30 % of the pull-off force (of approach for a tail)
    over 0.05 to 0.4 of the free way. By Derjaguin's rule what surrounds a contact pulls or pushes on as it did at
    touch: a charge and a brush stay."""
    bare = way(at)
    reach = rng.uniform(0.05, 0.4) * float(bare.z[bare.joined] - bare.z[0])
    size = _between(rng, 0.03, 0.3) * at.force
    if kind == "tail":
        return Reaching(-size * at.w_in / at.w, reach, bool(rng.random() < 0.5), stays=False)
    return Reaching(size if kind == "brush" else -size, reach, kind == "charge" and bool(rng.random() < 0.5))


# ---------------------------------------------------------------------- the kinds
def clean(rng: Rng) -> Made:
    """Make one of a wide range without any dirt, every third on a layer."""
    at = Setup.drawn(rng, bool(rng.random() < 1 / 3), (0.002, 0.5), (0.05, 30.0), (1e-3, 0.2))
    return recorded(rng, at, way(at))


def plain(rng: Rng) -> Made:
    at = Setup.drawn(rng)
    return recorded(rng, at, way(at))


def _beside(rng: Rng, *forces: Force, reaching: str = "") -> Made:
    """Make one with forces beside contact."""
    at = Setup.drawn(rng)
    path = way(at, _reaching(rng, at, reaching)) if reaching else way(at)
    return recorded(rng, at, path, path.F + sum((force(rng, at, path) for force in forces), np.zeros(path.z.size)))


def three(rng: Rng) -> Made:
    """Make one with three of the forces beside contact, at most one of which reaches over the gap."""
    names = ("tether", "quadratic", "wave", "drag", "decay", "reaching")
    chosen = rng.choice(names, 3, replace=False)
    reaching = str(rng.choice(["charge", "tail", "brush"])) if "reaching" in chosen else ""
    return _beside(rng, *(FORCES[name] for name in chosen if name in FORCES), reaching=reaching)


FORCES: dict[str, Force] = {
    "tether": tether_force, "tethers": tethers_force, "quadratic": quadratic_force, "wave": wave_force,
    "drag": drag_force, "decay": decay_force,
}  # fmt: skip


def saturated_top(rng: Rng) -> Made:
    """Limit the detector to 40 to 99 % of the largest load."""
    at = Setup.drawn(rng)
    path = way(at)
    made = recorded(rng, at, path)
    base = float(np.median(made.F[-20:]))
    return replace(made, F=np.minimum(made.F, base + rng.uniform(0.4, 0.99) * at.top))


def saturated_pull_off(rng: Rng) -> Made:
    """Limit the detector to 30 to 90 % of the largest tension."""
    at = Setup.drawn(rng)
    path = way(at)
    made = recorded(rng, at, path, without="w")
    base = float(np.median(made.F[-20:]))
    return replace(made, F=np.maximum(made.F, base + rng.uniform(0.3, 0.9) * float(path.F[path.turn :].min())))


def hold(rng: Rng) -> Made:
    """Hold the base at the turn, where 2 to 6 % of the load relax."""
    at = Setup.drawn(rng)
    path = way(at, course=Course(relaxed=rng.uniform(0.02, 0.06), held=rng.uniform(0.1, 0.5)))
    return recorded(rng, at, path, without="E_star")


def permanent_set(rng: Rng) -> Made:
    """Leave a dent of 10 to 40 % of the depth."""
    at = Setup.drawn(rng)
    depth = float(at.contact.functions[0][-1])
    return recorded(rng, at, way(at, course=Course(dent=depth * rng.uniform(0.1, 0.4))), without="E_star")


def second_contact(rng: Rng) -> Made:
    """Stretch a second contact from zero displacement on until it lets go at 5 to 40 % of the pull-off force, after 10
    to 60 % of the free way."""
    at = Setup.drawn(rng)
    bare = way(at)
    until = float(bare.z[bare.lost + int(rng.uniform(0.1, 0.6) * bare.free)])
    series = min(rng.uniform(0.05, 0.4) * at.force / -until, 0.8 * at.k)  # of spring and cantilever
    return recorded(rng, at, way(at, course=Course(spring=1 / (1 / series - 1 / at.k), until=until)))


def hysteresis(rng: Rng) -> Made:
    """Bow the positions of the retraction by 0.5 to 4 % of the travel, skewed, and scale them by up to 1 %."""
    at = Setup.drawn(rng)
    path = way(at)
    skewed = path.share ** rng.uniform(0.6, 1.6)
    bow = rng.uniform(0.005, 0.04) * 4 * skewed * (1 - skewed) + rng.uniform(-0.01, 0.01) * (1 - path.share)
    z = path.z - np.where(np.arange(path.z.size) >= path.turn, bow * path.span, 0.0)
    return recorded(rng, at, path, z=z, without="E_star")


def sensitivity(rng: Rng) -> Made:
    """Read 10 % more deflection than there is."""
    at = Setup.drawn(rng)
    path = way(at)
    return recorded(rng, at, path, F=1.1 * path.F, without="E_star")


def _alone(rng: Rng, retracts: bool) -> Made:
    at = Setup.drawn(rng)
    path = way(at)
    made = recorded(rng, at, path, without="w_approach" if retracts else "w")
    rows = slice(path.turn, None) if retracts else slice(path.turn)
    return replace(made, z=made.z[rows], F=made.F[rows], options={"segment": "retract" if retracts else "approach"})


def gaps(rng: Rng) -> Made:
    """Lose up to four stretches of 1 to 5 % of the rows, and repeat 1 to 5 % of the rows once."""
    at = Setup.drawn(rng)
    made = recorded(rng, at, way(at))
    count, rows = made.z.size, np.arange(made.z.size)
    for _ in range(int(rng.integers(1, 5))):
        first = int(rng.integers(rows.size))
        rows = np.delete(rows, slice(first, first + int(rng.uniform(0.01, 0.05) * count)))
    rows = np.sort(np.append(rows, rng.choice(rows, int(rng.uniform(0.01, 0.05) * count), replace=False)))
    return replace(made, z=made.z[rows], F=made.F[rows])


def pink(rng: Rng) -> Made:
    """Add 1/f noise of 0.3 to 3 % of the pull-off force."""
    at = Setup.drawn(rng)
    path = way(at)
    spectrum = np.fft.rfft(rng.normal(size=path.z.size))
    slow = np.fft.irfft(spectrum / np.sqrt(np.maximum(np.arange(spectrum.size), 1)), path.z.size)
    return recorded(rng, at, path, path.F + at.force * _between(rng, 0.003, 0.03) * slow / np.std(slow))


def layer(rng: Rng) -> Made:
    at = Setup.drawn(rng, layer=True, approach=(1.0, 1.0))
    return recorded(rng, at, way(at))


def layer_slower(rng: Rng) -> Made:
    at = Setup.drawn(rng, layer=True, approach=(0.3, 0.9))
    return recorded(rng, at, way(at))


def converter(rng: Rng) -> Made:
    """Round forces to 20 to 300 steps over the pull-off force."""
    at = Setup.drawn(rng)
    made = recorded(rng, at, way(at))
    step = at.force / _between(rng, 20, 300)
    return replace(made, F=np.round(made.F / step) * step)


def soft(rng: Rng) -> Made:
    """Take a cantilever that is 10 to 30 times softer than the contact."""
    at = Setup.drawn(rng, ratio=(10.0, 30.0))
    return recorded(rng, at, way(at))


KINDS: dict[str, Callable[[Rng], Made]] = {
    "clean": plain,
    "tether": lambda rng: _beside(rng, tether_force),
    "several tethers": lambda rng: _beside(rng, tethers_force),
    "charge": lambda rng: _beside(rng, reaching="charge"),
    "tail": lambda rng: _beside(rng, reaching="tail"),
    "brush": lambda rng: _beside(rng, reaching="brush"),
    "saturated top": saturated_top,
    "saturated pull-off": saturated_pull_off,
    "quadratic": lambda rng: _beside(rng, quadratic_force),
    "interference": lambda rng: _beside(rng, wave_force),
    "drag": lambda rng: _beside(rng, drag_force),
    "hold": hold,
    "permanent set": permanent_set,
    "second contact": second_contact,
    "hysteresis": hysteresis,
    "sensitivity": sensitivity,
    "retraction alone": lambda rng: _alone(rng, True),
    "approach alone": lambda rng: _alone(rng, False),
    "decaying drift": lambda rng: _beside(rng, decay_force),
    "gaps": gaps,
    "1/f noise": pink,
    "layer": layer,
    "layer, w_approach < w": layer_slower,
    "converter": converter,
    "soft lever": soft,
    "three at once": three,
}


# --------------------------------------------------------------------------------------------------
# Identities that the mechanics must hold.


def identities() -> list[tuple[str, float, float, float]]:
    """Return what is checked, the value found, the one expected and the relative error allowed."""
    R, E, w = 1e-5, 1e6, 0.05
    rows: list[tuple[str, float, float, float]] = []

    def functions(largest: float, sphere: bool, h: float | None, nu: float = 0.5) -> Sequence[Array]:
        return Contact(Tip(R, sphere), h, nu, largest).functions

    halfspace = Contact(Tip(R, False), None, 0.5, 3e-6)
    delta, P = halfspace.adhesive(E, w)
    rows.append(("pull-off force of JKR, -3/2 pi w R", float(P.min()), -1.5 * math.pi * w * R, 1e-5))
    lifted = float(P[int(np.argmin(delta))])
    rows.append(("at the least displacement, -5/6 pi w R", lifted, -5 / 6 * math.pi * w * R, 1e-3))
    small = [float(values[-1]) for values in functions(1e-7, True, None)]
    rows.append(("load of a sphere at a/R = 0.01, 4 E a^3/3R", small[1], 4e-21 / (3 * R), 1e-4))
    names = ("depth", "load", "stiffness", "edge")
    for name, thick, plain in zip(names, functions(1e-7, True, 1e-3), functions(1e-7, True, None), strict=True):
        rows.append((f"{name} of a thick layer, as of a half-space", float(thick[-1]), float(plain[-1]), 1e-3))
    # Thin limits, extrapolated from a/h = 10 and 20, of errors like h/a. Compressible: a foundation of modulus
    # m E*, m = (1 - nu)^2/(1 - 2 nu), over h. Incompressible: squeezed, with the shear modulus E*/4 over h^3.
    a, m = 3e-6, 0.7**2 / 0.4
    for name, index, ratio, power, expected in (
        ("depth of a thin layer, a^2/2R", 0, 0.3, 0, a**2 / (2 * R)),
        ("load of a thin layer, a foundation's", 1, 0.3, 1, math.pi * m * a**4 / (4 * R)),
        ("depth of a thin incompressible layer, a^2/4R", 0, 0.5, 0, a**2 / (4 * R)),
        ("stiffness of a thin incompressible layer", 2, 0.5, 3, 3 * math.pi * a**4 / 32),
    ):
        found = [punched(Tip(R, False), a / over, ratio, a, 96)[index] * (a / over) ** power for over in (10, 20)]
        rows.append((name, 2 * found[1] - found[0], expected, 0.1 if ratio == 0.5 else 0.01))
    # dP_H = S d delta_H along a contact that grows without adhesion; S' = pi^2 phi(a)^2/2 by the edge of a punch.
    layered = Contact(Tip(R, True), 2e-6, 0.4, 3e-6)
    depth, load, S, edge = layered.functions
    middle = RADII // 2
    rows.append(("dP/d delta, the stiffness", float(np.gradient(load, depth)[middle]), float(S[middle]), 1e-4))
    slope = float(np.gradient(S, layered.a)[middle])
    rows.append(("dS/da, pi^2 phi(a)^2/2", slope, math.pi**2 / 2 * float(edge[middle]) ** 2, 1e-4))
    return rows
