"""Kinds of dirt that no test needs, beside those of the tests' generator, in the order in which they are drawn."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from dirty_records import (  # type: ignore[import-not-found]
    KINDS as TESTED,
)
from dirty_records import (
    Attracted,
    Dirty,
    Drawn,
    Rng,
    branches,
    levelled,
    path,
    plain,
    recorded,
)


def header_words(rng: Rng) -> Dirty:
    """Loads and heights under the words that other programs use, with the height growing away from the specimen."""
    at = Drawn.of(rng)
    way = path(at)
    dirty = recorded(rng, at, way, way.P)
    z, P = dirty.columns["Z Piezo (nm)"] * 1e-9, dirty.columns["Deflection (nm)"] * 1e-9 * at.k
    height, load, factors = [
        ("Height (um)", "vDeflection (nN)", (-1e6, 1e9)), ("Raw Height Sensor [nm]", "Force [pN]", (-1e9, 1e12)),
        ("height (measured) / um", "Vertical deflection / nN", (-1e6, 1e9)), ("ZSnsr (m)", "Force (N)", (-1.0, 1.0)),
    ][int(rng.integers(4))]  # fmt: skip
    dirty.columns = {height: factors[0] * z, load: factors[1] * P}
    return replace(dirty, reasons=("--flip", "sign"))


def zero_columns(rng: Rng) -> Dirty:
    """Columns that an instrument writes and never fills."""
    dirty = plain(rng)
    zeros = np.zeros(dirty.at.rows * 2)
    dirty.columns = {**dirty.columns, "Contact Area (um^2)": zeros, "Stiffness (N/m)": zeros}
    return dirty


def phase_column(rng: Rng) -> Dirty:
    dirty = plain(rng)
    dirty.columns["Phase (deg)"] = np.round(
        rng.uniform(20, 80) + rng.normal(size=2 * dirty.at.rows), int(rng.integers(3))
    )
    return dirty


def dwell(rng: Rng) -> Dirty:
    """Friction of the piezo's lever and a dwell at the largest load."""
    at = Drawn.of(rng)
    way = path(at)
    P = way.P + at.force * rng.uniform(0.02, 0.2) * np.where(np.arange(way.z.size) < way.into, 1, -1)
    count = way.into // int(rng.integers(4, 12))
    z, P = (np.concatenate([v[: way.into], np.full(count, v[way.into - 1]), v[way.into :]]) for v in (way.z, P))
    return recorded(rng, at, way, P, z)


def tethers(rng: Rng) -> Dirty:
    return levelled(rng, 2)


def permanent_set(rng: Rng) -> Dirty:
    """Unloading to a dent of 10 to 40 % of the depth: no elastic model, in load control of an indenter."""
    at = Drawn.of(rng)
    depth = (3 * at.top / (4 * at.E * math.sqrt(at.R))) ** (2 / 3)
    rest, n = depth * rng.uniform(0.1, 0.4), at.rows
    share = np.linspace(0, 1, n)
    into, out = depth * share ** (2 / 3), rest + (depth - rest) * share[::-1] ** (2 / 3)
    free = np.linspace(-0.5 * depth, 0, n // 3)
    delta = np.concatenate([free, into, np.full(n // 10, depth), out, rest + free[::-1]])
    P = at.top * np.concatenate([0 * free, share, np.ones(n // 10), share[::-1], 0 * free])
    t = np.arange(P.size) / n
    P = P + at.top * 1e-3 * rng.normal(size=P.size)
    delta = delta + depth * 3e-4 * rng.normal(size=P.size)
    columns = {"Depth (nm)": 1e9 * delta, "Load (uN)": 1e6 * P, "Time (s)": t}
    reasons = ("directions differ", "rejected", "permanent", "dent", "misfit", "plastic")
    return Dirty(at, columns, {"E_star": math.nan}, [], reasons, rigid=True, determined=False)


def hysteresis(rng: Rng) -> Dirty:
    """A piezo without a sensor: its way out bulges by 0.5 to 4 % of the travel, skewed."""
    at = Drawn.of(rng)
    way = path(at)
    travel = float(np.ptp(way.z))
    share = (way.z - way.z.min()) / travel
    bulge, skew = rng.uniform(0.005, 0.04), rng.uniform(0.6, 1.8)
    out = np.arange(way.z.size) >= way.into
    z = way.z - np.where(out, bulge * travel * 4 * share**skew * (1 - share**skew), 0.0)
    reasons = ("directions differ", "rejected", "hysteresis", "misfit")
    return recorded(rng, at, way, way.P, z, reasons=reasons, determined=False)


def creep(rng: Rng) -> Dirty:
    """The piezo creeps after the reversal by 0.2 to 2 % of the travel a decade."""
    at = Drawn.of(rng)
    way = path(at)
    later = np.maximum(np.arange(way.z.size) - way.into, 0) / way.into
    z = way.z + np.ptp(way.z) * rng.uniform(0.002, 0.02) * np.log10(1 + later / 0.05)
    reasons = ("directions differ", "rejected", "creep", "misfit")
    return recorded(rng, at, way, way.P, z, reasons=reasons, determined=False)


def drift(rng: Rng) -> Dirty:
    """The specimen drifts by 0.05 to 1 % of the travel."""
    at = Drawn.of(rng)
    way = path(at)
    t = np.arange(way.z.size) / way.z.size
    z = way.z + np.ptp(way.z) * rng.choice([-1, 1]) * 10 ** rng.uniform(-3.3, -2) * t
    return recorded(rng, at, way, way.P, z, reasons=("drift", "differ", "rejected"), determined=False)


def wave(rng: Rng) -> Dirty:
    """Interference of the laser: a sine of 1 to 15 % of the pull-off force, 2 to 8 periods over the travel."""
    at = Drawn.of(rng)
    way = path(at)
    phase = 2 * math.pi * (rng.uniform(2, 8) * way.z / np.ptp(way.z) + rng.random())
    P = way.P + at.force * 10 ** rng.uniform(-2, math.log10(0.15)) * np.sin(phase)
    return recorded(rng, at, way, P, reasons=("wavy", "wave", "autocorrelated", "base line"))


def pink(rng: Rng) -> Dirty:
    """1/f noise of 0.3 to 3 % of the pull-off force."""
    at = Drawn.of(rng)
    way = path(at)
    spectrum = np.fft.rfft(rng.normal(size=way.z.size)) / np.sqrt(np.maximum(np.arange(way.z.size // 2 + 1), 1))
    slow = np.fft.irfft(spectrum, way.z.size)
    size = at.force * 10 ** rng.uniform(-2.5, -1.5)
    return recorded(rng, at, way, way.P + size * slow / np.std(slow), reasons=("wavy", "noisy", "autocorrelated"))


def approach_alone(rng: Rng) -> Dirty:
    at = Drawn.of(rng)
    way = path(at)
    dirty = recorded(
        rng, at, way, way.P, truth={"E_star": at.E, "w_approach": at.w_in}, options={"segment": "approach"}
    )
    dirty.columns = {name: values[: way.into] for name, values in dirty.columns.items()}
    return dirty


def retraction_alone(rng: Rng) -> Dirty:
    at = Drawn.of(rng)
    way = path(at)
    truth = {"E_star": at.E, "w": at.w}
    dirty = recorded(rng, at, way, way.P, truth=truth, options={"segment": "retract"})
    dirty.columns = {name: values[way.into :] for name, values in dirty.columns.items()}
    return dirty


def load_control(rng: Rng) -> Dirty:
    """An indenter that drives the load: the depth jumps where the contact comes, and runs away where it is lost."""
    at = Drawn.of(rng)
    stiff = replace(at, k=1e9 * at.E * at.R)
    (z, P), (back, tension) = branches(stiff, Attracted())
    low = int(np.argmin(tension))
    n = at.rows
    loads_in, loads_out = np.linspace(0, at.top, n), np.linspace(at.top, float(tension.min()), n)
    rise = int(np.argmin(P))
    into = np.interp(loads_in, P[rise:], z[rise:])
    out = np.interp(loads_out, tension[low:], back[low:])
    depth = float(np.ptp(out))
    free = np.linspace(-0.6 * depth, 0, n // 2)
    gone = np.linspace(out[-1] - 0.3 * depth, out[-1] - depth, n // 2)
    delta = np.concatenate([free, into, out, gone])
    P = np.concatenate([0 * free, loads_in, loads_out, 0 * gone])
    P = P + at.noise * rng.normal(size=P.size) + at.force * rng.uniform(-0.5, 0.5)
    columns = {"Depth (nm)": 1e9 * delta, "Load (nN)": 1e9 * P, "Time (s)": np.arange(P.size) / n}
    return Dirty(at, columns, at.truth, [], rigid=True)


OWN: dict[str, Callable[[Rng], Dirty]] = {
    "two tethers": tethers,
    "permanent set": permanent_set,
    "piezo hysteresis": hysteresis,
    "piezo creep": creep,
    "drift": drift,
    "interference": wave,
    "1/f noise": pink,
    "approach alone": approach_alone,
    "retraction alone": retraction_alone,
    "load control": load_control,
    "other header words": header_words,
    "columns of zeros": zero_columns,
    "phase column": phase_column,
    "dwell and friction": dwell,
}
ORDER = (
    "tether",
    "two tethers",
    "attraction",
    "van der Waals tail",
    "saturated",
    "saturated tension",
    "permanent set",
    "ringing",
    "coarse converter",
    "piezo hysteresis",
    "piezo creep",
    "drift",
    "interference",
    "1/f noise",
    "second contact",
    "other header words",
    "columns of zeros",
    "phase column",
    "sparse",
    "approach alone",
    "retraction alone",
    "large noise",
    "load control",
    "dwell and friction",
)  # by which they are drawn
KINDS = {kind: {**TESTED, **OWN}[kind] for kind in ORDER}
