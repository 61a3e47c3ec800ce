"""What roughness changes of the work of adhesion, on any stack: the elastic energy of full conformal contact.

A surface with the isotropic power spectrum C(q) (PSD, int C d2q = rms^2) that is pressed flat stores, per nominal area,

    U = (pi/2) E* int q^2 C(q)/g(q) dq,        one wave u cos(qx): E* q u^2/(8 g),

g the surface compliance of the stack over that of a half-space of its top material (``methods/layered/spectrum.py``), 1
on a half-space (Persson and Tosatti, J. Chem. Phys. 115 (2001) 5597; Dalvi et al., PNAS 116 (2019) 25484). With r the
true over the nominal area, small slopes: 1 + slope^2/2, and gamma the surface energy of the soft body,

    w_app = r w - gamma (r - 1) - U.

Full contact is one admissible state among others, so that w_app bounds the work of adhesion in equilibrium from below,
and the w that follows from a measured w_app is at most what it gives. Where U > w contact is partial, and its adhesion
is not known from U.

Conventions of spectra: contact.engineering's C_iso = (2 pi)^2 C, its curves q C_iso/pi, and the spectrum of profiles
C_1D(q) = (1/pi) int_q^inf C_iso(p) p/sqrt(p^2 - q^2) dp (Jacobs, Junge, Pastewka, Surf. Topogr. 5 (2017) 013001), of
which C_iso(q) = -2 int_q^inf C_1D'(p)/sqrt(p^2 - q^2) dp is the inverse.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import numpy as np

from ..base.arguments import read_fields
from ..base.errors import InputError, Refusal, accuracy, counted
from ..base.files import read_bytes
from ..base.numerics import Array, composite_gauss
from ..base.process import TEXT
from ..base.units import UNITS, Length, Ranged, Work, show
from ..bodies.problem import Problem
from ..methods.layered.spectrum import compliance, weighed_stacks
from ..tables.text import decoded, read_table

ROUGH_STEEP, ROUGH_STEEPEST = 0.3, 1.0  # theory: rms slopes that are no longer small, and for which nothing holds
ROUGH_PANEL = 0.5  # of ln q, panels of Gauss points; tuned on layers and half-spaces, by `make constants`
ROUGH_ACCURACY = 1e-9  # theory: g of graded layers is good to 1e-10, and so are the panels
ROUGH_FEWEST = 4  # theory: points of a table; every second one of fewer is no spectrum
ROUGH_RMS = 0.1  # choice: relative, by which the rms of a table and a given one may differ unsaid
ROUGH_WRONG = 2.0  # choice: factor between them from which another convention is looked for
ROUGH_BEYOND = np.geomspace(1.0, 1e4, 33)[1:]  # choice: times the last q, by which a profile's spectrum is continued
ROUGH_END = 6  # choice: points by which its power there is found
ROUGH_MOST = 150  # choice: intervals of ln q, over each of which a profile's spectrum is averaged where it has more
CONVENTIONS = {"C": 4, "C_iso": 4, "q_C_iso_over_pi": 3, "C_1D": 3}  # powers of length of a spectrum
SERIES = {"q/π × 2D PSD": "q_C_iso_over_pi", "1D PSD along x": "C_1D"}  # as contact.engineering heads its curves
Convention = Literal["C", "C_iso", "q_C_iso_over_pi", "C_1D"]


@dataclass(frozen=True, eq=False)
class PowerSpectrum:
    """Isotropic spectrum C [m^4] at wave numbers ``q`` [1/m], a power law from each to the next; of ``profiles`` C_1D
    [m^3], whose last power law goes on, ``steeper`` by so much. ``remarks``: on the table it was read from."""

    q: Array
    C: Array
    profiles: bool = False
    steeper: float = 0.0
    remarks: tuple[str, ...] = ()

    def at(self, q: Array) -> Array:
        """C(q) [m^4] at wave numbers within the band; of noisy profiles it may be negative."""
        x, logs = np.log(self.q), np.log(self.C)
        if not self.profiles:
            return np.exp(np.interp(np.log(q), x, logs))

        # C_iso(q) = 2 int p C_1D(q cosh s)/(q cosh s) ds, where C_1D falls with the power p
        power = min(np.polyfit(x[-ROUGH_END:], logs[-ROUGH_END:], 1)[0], -1.0) - self.steeper
        x = np.concatenate([x, x[-1] + np.log(ROUGH_BEYOND)])
        logs = np.concatenate([logs, logs[-1] + power * np.log(ROUGH_BEYOND)])
        falls, total = -np.diff(logs) / np.diff(x), np.zeros(q.size)
        for i, k in enumerate(q):
            edges = np.arccosh(np.maximum(np.exp(x) / k, 1.0))
            s, weights = composite_gauss(edges)
            p = k * np.cosh(s)
            total[i] = np.sum(weights * falls[:, None] * np.exp(np.interp(np.log(p), x, logs)) / p)
        return 2 * total / (2 * math.pi) ** 2

    def moment(self, power: int, problem: Problem | None = None, least: float = 0.0) -> float:
        """2 pi int q^power C/g dq over waves from ``least`` [1/m] on; g = 1 without a ``problem``."""
        first, last = math.log(max(least, self.q[0])), math.log(self.q[-1])
        if not first < last:
            return 0.0
        x = np.union1d([first, *np.log(self.q[self.q > least])], np.arange(first, last, ROUGH_PANEL))
        nodes, weights = (part.ravel() for part in composite_gauss(x))
        q = np.exp(nodes)
        g = np.ones_like(q) if problem is None else relative_compliance(problem, q)
        return float(2 * math.pi * np.sum(weights * q ** (power + 1) * self.at(q) / g))

    @property
    def rms(self) -> float:
        """Root mean square of the heights [m]: rms^2 = 2 pi int q C dq."""
        return math.sqrt(max(self.moment(1), 0.0))

    @cached_property
    def slope(self) -> float:
        """Root mean square of the slope [-], of the whole gradient: slope^2 = 2 pi int q^3 C dq."""
        return math.sqrt(max(self.moment(3), 0.0))

    @property
    def waves(self) -> tuple[float, float]:
        """The shortest and the longest wave [m]."""
        return 2 * math.pi / float(self.q[-1]), 2 * math.pi / float(self.q[0])

    def within(self, shortest: float | None, longest: float | None) -> PowerSpectrum:
        """The part between two wavelengths [m]."""
        ends = [self.q[0] if longest is None else max(2 * math.pi / longest, self.q[0]),
                self.q[-1] if shortest is None else min(2 * math.pi / shortest, self.q[-1])]  # fmt: skip
        if not ends[0] < ends[1]:
            low, high = (show(wave, "length") for wave in self.waves)
            raise InputError(f"roughness: shortest and longest leave nothing of the spectrum, from {low} to {high}")
        q = np.concatenate([ends[:1], self.q[(self.q > ends[0]) & (self.q < ends[1])], ends[1:]])
        return replace(self, q=q, C=np.exp(np.interp(np.log(q), np.log(self.q), np.log(self.C))))


def relative_compliance(problem: Problem, q: Array) -> Array:
    """Surface compliance g(q) of both bodies over that of half-spaces of their surfaces; small ones keep their relative
    accuracy."""
    stacks = weighed_stacks(problem.specimen, problem.indenter.material)
    rest = np.full(q.shape, 1.0 - sum(share for _, share in stacks))
    return sum((share * compliance(body, q)[0] for body, share in stacks), rest)


# --------------------------------------------------------------------------------------------------
# A roughness as it is given: by four numbers, or by the table of its spectrum.


@dataclass(frozen=True, kw_only=True)
class Roughness:
    """Roughness by its ``rms`` height, ``longest`` and ``shortest`` wave [m] and ``hurst`` exponent H, C ~ q^(-2 - 2 H)
    between, or by a file ``psd`` of q and C, whose ``convention`` is named: "C" (int C d2q = rms^2), "C_iso" (that of
    contact.engineering, 39.5 times C), "q_C_iso_over_pi" (its curves) or "C_1D" (profiles).

    With a table ``rms`` is compared with that of the table, and waves beyond ``longest`` and ``shortest`` are left out.
    ``surface_energy``: gamma of the soft body [J/m^2], whose free surface is flat; None: r = 1 is taken.
    """

    rms: Length | None = None
    longest: Length | None = None
    shortest: Length | None = None
    hurst: Annotated[float, Ranged("number", above=0, most=1)] | None = None
    psd: str | Path | None = None
    convention: Convention | None = None
    surface_energy: Work | None = None

    def __post_init__(self) -> None:
        read_fields(self, "roughness")
        numbers = {name: getattr(self, name) for name in ("rms", "longest", "shortest", "hurst")}
        missing = [name for name, value in numbers.items() if value is None]
        if self.psd is None and (missing or self.convention is not None):
            what = f"{', '.join(missing)} missing" if missing else "convention is of a table"
            raise InputError(
                f"roughness: {what}: give rms, longest, shortest and hurst, or psd=FILE with its convention"
            )
        if self.psd is not None and self.hurst is not None:
            raise InputError("roughness: hurst is in the table of psd already: leave it out")
        if self.longest is not None and self.shortest is not None and not self.shortest < self.longest:
            raise InputError("roughness: the shortest wave must be shorter than the longest, got "
                             f"{show(self.shortest, 'length')} and {show(self.longest, 'length')}")  # fmt: skip

    @classmethod
    def of_words(cls, pairs: Mapping[str, str] | None, surface_energy: float | None) -> Roughness | None:
        """The roughness that options give; None without one."""
        if pairs is None:
            if surface_energy is not None:
                raise InputError("--surface-energy has no effect without --roughness: leave it out")
            return None
        known = ("rms", "longest", "shortest", "hurst", "psd", "convention")
        if unknown := [key for key in pairs if key not in known]:
            raise InputError(f'--roughness: unknown key "{unknown[0]}" (allowed: {", ".join(known)})')
        return cls(**pairs, surface_energy=surface_energy)  # type: ignore[arg-type]

    @cached_property
    def spectrum(self) -> PowerSpectrum:
        """The spectrum; InputError where a table cannot be one."""
        if self.psd is None:
            rms, longest, shortest, hurst = cast("list[float]", [self.rms, self.longest, self.shortest, self.hurst])
            q = 2 * math.pi / np.array([longest, shortest])
            law = PowerSpectrum(q, q ** (-2 - 2 * hurst) / q[0] ** (-2 - 2 * hurst) * longest**4)
            return replace(law, C=law.C * (rms / law.rms) ** 2)
        table = read_spectrum(Path(self.psd), self.convention)
        return self._compared(table).within(self.shortest, self.longest)

    def _compared(self, table: PowerSpectrum) -> PowerSpectrum:
        """The ``table`` with a remark where its rms is not the one that is given."""
        if self.rms is None or abs((rms := table.rms) / self.rms - 1) < ROUGH_RMS:
            return table
        off = f"rms of {self.psd} is {show(rms, 'length')}, {show(self.rms, 'length')} is given"
        if abs(math.log(rms / self.rms)) < math.log(ROUGH_WRONG):
            return replace(table, remarks=(*table.remarks, off))
        others = {name: read_spectrum(Path(str(self.psd)), name, units=False) for name in CONVENTIONS}
        fit = [name for name, other in others.items() if abs(other.rms / self.rms - 1) < ROUGH_RMS]
        raise InputError(
            f"roughness: {off}: {f'convention={fit[0]} gives it' if fit else 'its convention, its units?'}"
        )

    def on(self, problem: Problem) -> RoughContact:
        """What it changes between the bodies of ``problem``; Refusal where that is not derived."""
        reasons = {
            "specimen.surface_tension": problem.specimen.surface_tension > 0,
            "specimen.relaxation": problem.specimen.relaxation is not None,
            'surface = "sticking"': problem.sticks,
        }
        if wrong := [name for name, there in reasons.items() if there]:
            raise Refusal(f"roughness: its energy is not derived with {wrong[0]}: leave it out, or the roughness")
        spectrum, E_star = self.spectrum, problem.E_star
        if spectrum.slope > ROUGH_STEEPEST:
            rms, shortest = show(spectrum.rms, "length"), show(spectrum.waves[0], "length")
            raise Refusal(
                f"roughness: the rms slope {spectrum.slope:.3g} (rms {rms}, waves down to {shortest}) is above "
                f"{ROUGH_STEEPEST:g}, and U and r are those of small slopes: shortest=... leaves waves out"
            )
        energy, error = E_star / 4 * spectrum.moment(2, problem), ROUGH_ACCURACY
        if self.psd is not None:  # what every second point leaves
            half = replace(spectrum, q=spectrum.q[::-2][::-1], C=spectrum.C[::-2][::-1]).within(*spectrum.waves)
            error += abs(half.moment(2, problem, spectrum.q[0]) / spectrum.moment(2, problem, half.q[0]) - 1)
        if spectrum.profiles:  # and what goes on beyond the last wave of profiles
            error += abs(replace(spectrum, steeper=1.0).moment(2, problem) / spectrum.moment(2, problem) - 1)
        inner = [spectrum.moment(2, problem, q) * E_star / 4 for q in (2 * spectrum.q[0], spectrum.q[-1] / 2)]
        half_space, gamma = E_star / 4 * spectrum.moment(2), self.surface_energy
        return RoughContact(spectrum, energy, error * energy, half_space, (energy - inner[0], inner[1]), gamma)


def read_spectrum(path: Path, convention: str | None, units: bool = True) -> PowerSpectrum:
    """The spectrum in a table of q and C, by the ``convention`` that is named, or that contact.engineering's heading
    says; InputError where there is none. ``units``: whether those of the header must be of that convention."""
    content = read_bytes(path, "spectrum", TEXT)
    curves, heading, header = dict[str, list[str]](), "", ""
    for line in decoded(content).splitlines():
        words = line.lstrip("#").strip()
        if line.startswith("#"):
            heading = words if words in SERIES or "PSD along" in words or "2D PSD" in words else heading
            header = words if words.startswith("Columns:") else header
        elif words:
            curves.setdefault(heading, []).append(line)
    there = {SERIES[name]: rows for name, rows in curves.items() if name in SERIES}
    if there:
        convention = next(iter(there)) if convention is None else convention
        if convention not in there:
            raise InputError(f"{path}: holds no curve of convention {convention} (conventions: {', '.join(there)})")
        content = "\n".join(there[convention]).encode()
    if convention is None:
        raise InputError(f"{path}: says not which spectrum it holds: give convention={', '.join(CONVENTIONS)}")
    table = read_table(path, least=2, finite=False, content=content)
    titles = [header.partition(",")[0], header.partition(",")[2]] if there else list(table.names[:2])
    powers = (-1, CONVENTIONS[convention]) if units else (None, None)
    factors = [_factor(path, *each) for each in zip(titles, powers, strict=True)]
    q, C = (table.values[:, i] * factor for i, factor in enumerate(factors))
    used = (q > 0) & (C > 0) & np.isfinite(q) & np.isfinite(C)
    q, C = q[used], C[used]
    if q.size < ROUGH_FEWEST or not (np.diff(q) > 0).all():
        what = f"holds {counted(q.size, 'row')} with q and C > 0" if q.size < ROUGH_FEWEST else "q must rise: several"
        raise InputError(f"{path}: {what}{' spectra in one table?' if q.size >= ROUGH_FEWEST else ', 4 are needed'}")
    remarks = [f"{counted(int((~used).sum()), 'row')} without q > 0 and C > 0 left out"] * bool((~used).any())
    scale: dict[str, Array | float] = {
        "C": 1.0,
        "C_iso": (2 * math.pi) ** -2,
        "q_C_iso_over_pi": math.pi / q / (2 * math.pi) ** 2,
        "C_1D": 1.0,
    }
    if convention == "C_1D" and q.size > ROUGH_MOST:
        interval = np.floor(np.log(q / q[0]) / np.log(q[-1] / q[0]) * ROUGH_MOST)
        counts = np.unique(interval, return_counts=True)[1]
        begins = np.cumsum(counts) - counts
        q, C = np.exp(np.add.reduceat(np.log(q), begins) / counts), np.add.reduceat(C, begins) / counts
    return PowerSpectrum(q, C * scale[convention], convention == "C_1D", remarks=tuple(remarks))


def _factor(path: Path, title: str, power: int | None) -> float:
    """The factor to SI of the unit in a header cell, "q (1/um)", "PSD (µm³)"; 1 where it names none; InputError where
    it is not a length to the ``power`` (None: any)."""
    plain = title.translate(str.maketrans("⁻¹²³⁴µμ", "-1234uu"))
    found = re.search(r"[\[(]\s*(?:rad\s*)?([^\])]*?)\s*[\])]", plain)
    if found is None:
        return 1.0
    unit = re.fullmatch(r"(1?/)?([A-Za-zÅ]+)\^?(-?\d)?", found[1].replace(" ", ""))
    if unit is None or unit[2] not in UNITS["length"]:
        raise InputError(f'{path}: "{title}": the unit "{found[1]}" is no power of a length, such as 1/um or nm^4')
    own = int(unit[3] or 1) * (-1 if unit[1] else 1)
    if power is not None and own != power:
        raise InputError(f'{path}: "{title}": this convention has a unit of m^{power}, got "{found[1]}": another one?')
    return 10.0 ** (own * UNITS["length"][unit[2]])


# --------------------------------------------------------------------------------------------------
# What it changes between two bodies.


@dataclass(frozen=True, eq=False)
class RoughContact:
    """A ``spectrum`` between two bodies: the elastic ``energy`` U of full contact with its ``error``, that of a
    ``half_space`` of the surface's modulus and, in U, of the longest and the shortest of its ``octaves``;
    ``surface_energy``: gamma, None where r = 1 is taken; all [J/m^2]."""

    spectrum: PowerSpectrum
    energy: float
    error: float
    half_space: float
    octaves: tuple[float, float]
    surface_energy: float | None

    @property
    def area(self) -> float:
        """True over nominal area r [-]."""
        return 1.0 if self.surface_energy is None else 1 + self.spectrum.slope**2 / 2

    def apparent(self, w: float) -> float:
        """w_app = r w - gamma (r - 1) - U [J/m^2] of a ``w`` between smooth surfaces; Refusal where it is not > 0."""
        gained = self.area * w - (self.surface_energy or 0.0) * (self.area - 1)
        if w > 0 and gained <= self.energy:
            raise Refusal(
                f"roughness: no adhesion by conformal contact: flattening it takes U = {show(self.energy, 'work')}, "
                f"true contact gains {show(gained, 'work')}; contact is partial, and its pull-off is not known"
            )
        return gained - self.energy if w > 0 else 0.0

    def smooth(self, w: float) -> float:
        """The work of adhesion between smooth surfaces of which ``w`` [J/m^2] was measured, at most."""
        return (w + (self.surface_energy or 0.0) * (self.area - 1) + self.energy) / self.area

    def error_at(self, w: float) -> float:
        """Half-width of w_app [J/m^2] of a ``w`` between smooth surfaces: that of U, and slope^4/4 of r."""
        by_area = 0.0 if self.surface_energy is None else (w - self.surface_energy) * self.spectrum.slope**4 / 4
        return self.error + abs(by_area)

    def warnings(self, a: float | None = None) -> Sequence[str]:
        """What is doubtful, with a contact of radius ``a`` [m] at pull-off."""
        slope, longest = self.spectrum.slope, self.spectrum.waves[1]
        steep = f"roughness: the rms slope {slope:.2g} is above {ROUGH_STEEP}: U and r are those of small slopes"
        wide = "" if a is None else (
            f"roughness: its longest wave {show(longest, 'length')} is longer than the contact is wide at pull-off "
            f"({show(2 * a, 'length')}): such waves are shape, no roughness: longest=... leaves them out"
        )  # fmt: skip
        remarks = [f"roughness: {remark}" for remark in self.spectrum.remarks]
        return [*[steep] * (slope > ROUGH_STEEP), *[wide] * (a is not None and longest > 2 * a), *remarks]

    def words(self) -> list[str]:
        """Sizes and energy."""
        spectrum = self.spectrum
        shortest, longest = (show(wave, "length") for wave in spectrum.waves)
        over = "" if self.energy == self.half_space else f", {self.energy / self.half_space:.3g} times a half-space's"
        area, (long, short) = f"r = {self.area:.6g}", (part / self.energy for part in self.octaves)
        if self.surface_energy is None:
            area = f"r = 1 taken (by slopes {1 + spectrum.slope**2 / 2:.4g}): --surface-energy is not given"
        return [
            f"elastic energy U = {show(self.energy, 'work')}{over}, {accuracy(self.error / self.energy)}; {area}",
            f"roughness: rms {show(spectrum.rms, 'length')}, rms slope {spectrum.slope:.2g}, waves from {shortest} to "
            f"{longest}; {long:.0%} of U in the longest octave, {short:.0%} in the shortest",
        ]

    def summary(self) -> dict[str, Any]:
        """Sizes and energy, SI."""
        shortest, longest = self.spectrum.waves
        return {
            "rms_m": self.spectrum.rms, "rms_slope": self.spectrum.slope, "shortest_m": shortest, "longest_m": longest,
            "elastic_energy_J_per_m2": self.energy, "elastic_energy_err_J_per_m2": self.error,
            "elastic_energy_half_space_J_per_m2": self.half_space,
            "elastic_energy_of_longest_octave_J_per_m2": self.octaves[0],
            "elastic_energy_of_shortest_octave_J_per_m2": self.octaves[1],
            "area_ratio": self.area, "surface_energy_J_per_m2": self.surface_energy,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class RoughWork:
    """A work of adhesion ``w`` [J/m^2] between smooth surfaces, in a rough ``contact``."""

    contact: RoughContact
    w: float

    def words(self) -> list[str]:
        """What becomes of it, then sizes and energy."""
        contact, w = self.contact, self.contact.apparent(self.w)
        known = accuracy(contact.error_at(self.w) / w if w else 0.0)
        smooth = f"{show(self.w, 'work')} between smooth surfaces"
        return [f"w = {show(w, 'work')} at least, by full conformal contact, of {smooth}; {known}", *contact.words()]

    def summary(self) -> dict[str, Any]:
        """w of both, and the roughness, SI."""
        return {
            "w_smooth_J_per_m2": self.w,
            "w_bound": "lower",
            "w_err_by_roughness_J_per_m2": self.contact.error_at(self.w),
            "roughness": self.contact.summary(),
        }


def works_on(
    roughness: Roughness | None, problem: Problem, works: Sequence[float], ranged: bool = False
) -> tuple[Sequence[float], Sequence[RoughWork | None]]:
    """The ``works`` of adhesion [J/m^2] as they act between the bodies of ``problem``, and what each is by; Refusal
    where adhesion is ``ranged``, of finite range."""
    if roughness is None:
        return works, [None] * len(works)
    if ranged:
        raise Refusal("roughness: its energy is not derived with adhesion of finite range: leave stress and range out")
    contact = roughness.on(problem)
    return [contact.apparent(w) for w in works], [RoughWork(contact, w) for w in works]
