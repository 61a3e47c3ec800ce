"""`make validation`: what this program computes against published and independent values, as the tables of a page.

Each row states its source and its tolerance; a row beyond it makes the command fail. Independent are values that no
code of jkrcli made: closed forms written out here, numbers of publications, other programs, and a second solution of
the contact equation by plain quadrature, below.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

import jkrcli as jkr
from jkrcli.adhesion.device_path import stability_under

PAGE = Path(__file__).parents[1] / "project" / "validation-tables.md"
HAYES = "Hayes 1972"
MAUGIS = "Maugis 1978"
JKR = "JKR 1971"
HUI = "Hui 2015"
SNEDDON = "Sneddon 1965"
PAPER = "paper"
ROUND_OFF = 1e-12  # of which a page tells no more: it differs among machines
QUADRATURE = "quadrature"
APART = "second program"
SOURCES = {
    JKR: "Johnson, Kendall and Roberts, Proc. R. Soc. A 324 (1971) 301",
    MAUGIS: "Maugis and Barquins, J. Phys. D 11 (1978) 1989",
    SNEDDON: "Sneddon, Int. J. Eng. Sci. 3 (1965) 47: P = E* [(R² + a²) artanh(a/R) − a R]",
    HAYES: "Hayes, Keer, Herrmann and Mockros, J. Biomech. 5 (1972) 541; further digits by two programs",
    HUI: "Hui, Liu, Salez, Raphael and Jagota, Proc. R. Soc. A 471 (2015) 20140727: wetting limit",
    PAPER: "Jiang, Borodich, Perepelkin and Jin",
    QUADRATURE: "a second solution of the equations in `docs/validation/validate.py`",
    APART: "programs and derivations that share no code with `jkr`",
}


@dataclass(frozen=True)
class Row:
    """A quantity, its value here and elsewhere, where that is from, and the relative difference that is allowed."""

    what: str
    computed: float
    reference: float
    source: str
    tolerance: float

    @property
    def difference(self) -> float:
        return abs(self.computed / self.reference - 1)

    @property
    def line(self) -> str:
        least = min(ROUND_OFF, self.tolerance)
        off = f"{self.difference:.0e}" if self.difference > least else f"<{least:.0e}"
        return f"| {self.what} | {self.computed:.8g} | {self.reference:.8g} | {off} | {self.source} |"


# ---------------------------------------------------------------------- independent solution
def plain_stiffness(nu: float, a: float, nodes: int = 160) -> float:
    """S/(2 E* a) of a flat punch of radius ``a`` on a bonded layer of unit thickness: Lebedev and Ufliand's equation by
    Gauss points on the radius and on a cut half-axis of wave numbers."""
    y, weight = np.polynomial.legendre.leggauss(800)
    k, dk = 20 * (y + 1), 20 * weight
    kappa = 3 - 4 * nu
    g = (2 * kappa * np.sinh(2 * k) - 4 * k) / (2 * kappa * np.cosh(2 * k) + 1 + kappa**2 + 4 * k**2)
    t, dt = np.polynomial.legendre.leggauss(nodes)
    t, dt = a * (t + 1) / 2, a * dt / 2
    K = (np.cos(np.outer(t, k)) * ((g - 1) * dk)) @ np.cos(np.outer(k, t))
    phi = np.linalg.solve(np.eye(nodes) + 2 / math.pi * K * dt, np.full(nodes, 2 / math.pi))
    return float(math.pi * phi @ dt / (2 * a))


# ---------------------------------------------------------------------- rows
def plain_tension(kappa: float, terms: int = 12, most: float = 1500.0) -> float:
    """S/(2 E* a) of a flat end of a = 1 on a half-space with surface tension, kappa = 2 Ups/(E* a), in Hankel space.

    Chebyshev polynomials of t over sqrt(1 - t^2), whose transforms are Bessel functions; Gauss panels in k.
    """
    from scipy.special import jv

    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.concatenate([[0.0], np.geomspace(1e-3, 1, 20), np.arange(2, most + 0.5)])
    half = np.diff(edges)[:, None] / 2
    k, w = np.ravel(edges[:-1, None] + half * (1 + nodes)), np.ravel(half * weights)
    orders = np.arange(terms)
    J = jv(2 * orders[:, None], k) * (-1.0) ** orders[:, None]
    A = (J * (w / (1 + kappa * k))) @ J.T + 1 / (math.pi * kappa * most)
    return math.pi / 2 * float(np.linalg.solve(A, np.eye(terms)[0])[0])


def bonded(nu: float, h: float = 1.0, E: float = 1.0) -> jkr.Specimen:
    return jkr.Specimen((jkr.Layer(jkr.Elastic(E, nu), h),), jkr.Rigid(bonded=True))


@cache
def at(specimen: jkr.Specimen, a: float, method: object = None) -> object:
    """The series of a blunt paraboloid at one contact radius and ten smaller ones."""
    radii = tuple(np.linspace(0.05, 1, 20) * a)
    return jkr.solve(jkr.Problem(jkr.Paraboloid(1000.0), specimen, jkr.Loading.given("radius", radii)), method).series


def classical() -> Iterator[Row]:
    """Half-space, paraboloid."""
    R, w, E = 10e-6, 0.05, 1e6
    problem = jkr.Problem(jkr.Paraboloid(R), jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(E, 0.3))),
                          jkr.Loading("radius", 5e-6, 100))  # fmt: skip
    for method in (jkr.ClosedForm(), jkr.Layered()):
        curve, name = jkr.transform(jkr.solve(problem, method), w=w), f"`{type(method).__name__}`"
        force = curve.pull_off["load"].P / (math.pi * w * R)
        rigid = curve.pull_off["displacement"].P / (math.pi * w * R)
        yield Row(f"half-space, {name}: pull-off/πwR, load", -force, 1.5, JKR, 1e-12)
        yield Row(f"half-space, {name}: pull-off/πwR, displacement", -rigid, 5 / 6, MAUGIS, 1e-11)
        E_star = E / (1 - 0.3**2)
        soft, stiff = stability_under(curve.curve, 0.0), stability_under(curve.curve, math.inf)
        zero = 6 * math.pi * w * R**2 * 3 / (4 * E_star)
        yield Row(f"half-space, {name}: 2E*a³/9πwR² at P=0", soft.jump_in.a**3 / zero, 1.0, JKR, 1e-12)
        contact = math.pi * w * R**2 * 2 / E_star
        yield Row(f"half-space, {name}: E*a³/2πwR² at δ=0", stiff.jump_in.a**3 / contact, 1.0, MAUGIS, 1e-12)


def sphere() -> Iterator[Row]:
    """Exact sphere."""
    specimen = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0)))
    problem = jkr.Problem(jkr.Sphere(1.0), specimen, jkr.Loading.given("radius", (0.25, 0.5)))
    exact = (1 + 0.25) * math.atanh(0.5) - 0.5
    for method in (jkr.ClosedForm(), jkr.Layered()):
        P = float(jkr.solve(problem, method).series.P[-1])
        yield Row(f"sphere, `{type(method).__name__}`: P/E*R² at a=R/2", P, exact, SNEDDON, 1e-13)


def layers() -> Iterator[Row]:
    """Bonded layer: κ = S/2E*a."""
    published = {(0.3, 0.2): 1.20656, (0.3, 0.6): 1.78475, (0.3, 1.0): 2.48352, (0.5, 1.0): 3.61874}
    for (nu, a), factor in published.items():
        found = at(bonded(nu), a).S[-1] * (1 - nu**2) / (2 * a)
        yield Row(f"κ, ν={nu:g}, a/h={a:g}, published", found, factor, HAYES, 6e-6)
    for nu, a in ((0.3, 1.0), (0.3, 5.0), (0.499, 5.0), (0.5, 5.0)):
        found = at(bonded(nu), a).S[-1] * (1 - nu**2) / (2 * a)
        yield Row(f"κ, ν={nu:g}, a/h={a:g}", found, plain_stiffness(nu, a), QUADRATURE, 1e-10)


def thin() -> Iterator[Row]:
    """Pull-off from a bonded layer: thick and thin limit, q = w R²/E* h³."""
    for nu, q, force, tolerance in ((0.3, 1e-6, 1.5, 1e-5), (0.3, 1e6, 2.0, 1e-2)):
        (found,) = jkr.study_map("pull-off", nu=[nu], q=[q]).columns["minus_P_over_pi_w_R"]
        name = f"layer: pull-off/πwR, ν={nu:g}, q={q:g}"
        yield Row(name, found, force, JKR if q < 1 else PAPER, tolerance)


def others() -> Iterator[Row]:
    """Two methods that share no code."""
    gel = bonded(0.499, 0.36e-3, 15e3)
    for method, tolerance in ((jkr.Hybrid(), 1e-6), (jkr.FEM(), 1e-3)):
        problem = jkr.Problem(jkr.Sphere(6e-3), gel, jkr.Loading("radius", 1.2e-3, 100))
        here, exact = (jkr.transform(jkr.solve(problem, one), w=0.04).pull_off["load"].P
                       for one in (method, jkr.Layered()))  # fmt: skip
        yield Row(f"gel, `{type(method).__name__}`: pull-off [mN]", -1e3 * here, -1e3 * exact, "`Layered`", tolerance)
    yield Row("gel, `Layered`: pull-off [mN]", -1e3 * exact, 1.4833, APART, 4e-5)
    cylinder = replace(bonded(0.3), radius=3.0, side="free")
    problem = jkr.Problem(jkr.Paraboloid(1000.0), cylinder, jkr.Loading("radius", 2.0, 60))
    hybrid, fem = (jkr.solve(problem, method).series for method in (jkr.Hybrid(), jkr.FEM(tolerance=1e-4)))
    delta = float(fem.delta[-2])
    loads = [float(np.exp(np.interp(np.log(delta), np.log(one.delta), np.log(one.P)))) for one in (hybrid, fem)]
    yield Row("free cylinder, `Hybrid`: P", *loads, "`FEM`", 5e-6)


def tension() -> Iterator[Row]:
    """Surface tension Υ."""
    for kappa in (0.1, 1.0, 10.0):
        soft = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(E=0.91, nu=0.3)), surface_tension=kappa / 2)
        found = at(soft, 1.0).S[-1] / 2
        yield Row(f"surface tension: κ, half-space, 2Υ/E*a={kappa:g}", found, plain_tension(kappa), QUADRATURE, 1e-5)
    (force,) = jkr.study_map("pull-off", nu=[0.5], q=[1.0], beta=100.0).columns["minus_P_over_pi_w_R"]
    yield Row("surface tension: pull-off/πwR, Υ=100E*a0", force, 1.0, HUI, 3e-3)


def relaxation() -> Iterator[Row]:
    """Viscoelastic specimen: depth 1 at t = 1 and back, r = 1/4 + 3/4 exp(-t), E* = R = 1."""
    solid = jkr.StandardSolid(0.25, 1.0)
    half = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(1.0, 0.0)))
    exact = {1.0: 1.02621407, 1.25: 0.45146169, 1.5: 0.08167490}
    bodies = (("half-space", half, 1.0, exact, 1e-7), ("layer, ν=½, h=0.8", bonded(0.5, 0.8, 0.75),
              0.436692733, {1.0: 1.19977308, 1.25: 0.40694176, 1.5: 0.04468622}, 1e-6))  # fmt: skip
    for name, specimen, depth, loads, tolerance in bodies:
        problem = jkr.Problem(jkr.Paraboloid(1.0), specimen, jkr.Loading("depth", 1.001 * depth))
        history = jkr.cycle_relaxing(jkr.solve(problem), solid, depth, to_depth=depth)
        for t, load in loads.items():
            yield Row(
                f"viscoelastic {name}: P, t={t:g}", float(history.states(np.array([t]))[2][0]), load, APART, tolerance
            )
        if depth == 1:
            yield Row("viscoelastic half-space: time of pull-off", history.lost or math.nan, 1.62384979, APART, 1e-8)
            y, weight = np.polynomial.legendre.leggauss(60)
            s = (1 + y) / 2  # of s = x^2, in which the loads are smooth
            plain = 4 * float(np.sum(weight / 2 * s**2 * (0.25 + 0.75 * np.exp(s**2 - 1))))
            yield Row(
                "viscoelastic half-space: P, t=1, integral",
                float(history.states(np.array([1.0]))[2][0]),
                plain,
                QUADRATURE,
                1e-9,
            )


def relaxing_adhesion() -> Iterator[Row]:
    """Adhesion by a cohesive stress on a viscoelastic half-space, w/E∞*R = 0.05, λ = 3: limits, from rest."""
    w, a0, solid = 0.05, 0.05 ** (1 / 3), jkr.StandardSolid(0.1, 1.0)
    half = jkr.Specimen((), jkr.HalfSpace(jkr.Elastic(10.0, 0.0)), relaxation=solid)
    solved = jkr.solve(jkr.Problem(jkr.Paraboloid(1.0), half, jkr.Loading("depth", 6 * a0**2)))
    stress = 1.5 * (math.pi * w * (4 / 3) ** 2) ** (1 / 3)
    name, references = "viscoelastic, λ=3: pull-off/πwR", {1.0: (7.881, 2e-3), 0.01: (3.430, 2e-3)}
    for speed, (force, tolerance) in references.items():
        history = jkr.cycle_relaxing(solved, w=w, stress=stress, speed=speed, rest_depth=0.0)
        yield Row(f"{name}, Vτ/R={speed:g}", -history.pull_off.P / (math.pi * w), force, APART, tolerance)
    limits = {"very fast": (1.6701, 1e-4), "very slow": (1.5168, 1e-4), "from rest": (9.9824, 1e-4)}
    for limit, (force, tolerance) in limits.items():
        yield Row(f"{name}, {limit}", -history.limits[limit].P / (math.pi * w), force, APART, tolerance)
    elastic = jkr.cycle_relaxing(
        solved, relaxation=jkr.StandardSolid(1.0, 1.0), w=w, stress=stress, speed=1.0, rest_depth=0.0
    )
    yield Row(f"{name}, ratio 1", -elastic.pull_off.P / (math.pi * w), 1.6701, APART, 1e-3)


def paper() -> Iterator[Row]:
    """Numbers of the paper."""
    from jkrcli.formulas import tabor

    E_star = 5e9 / (1 - 0.4**2)
    for w, R, printed in ((50.0, 1e-4, 639), (10.0, 1e-3, 471)):
        yield Row(f"Tabor number, w={w:g} J/m², R={R * 1e3:g} mm", tabor(R, w, E_star, 0.3e-9), printed, PAPER, 1e-3)


SECTIONS = (classical, sphere, layers, thin, others, tension, relaxation, relaxing_adhesion, paper)
HEAD = "| quantity | `jkr` | reference | difference | source |\n|---|---|---|---|---|"


def page() -> tuple[str, list[Row]]:
    """The page, and the rows that are further off than they may be."""
    rows = [row for section in SECTIONS for row in section()]
    parts = [
        "# Validation tables",
        "`make validation` writes this table and fails where a relative difference exceeds its limit in "
        "`docs/validation/validate.py`. Bonded layers on a rigid substrate, κ = S/2E\\*a, q = w R²/E\\* h³; "
        "viscoelastic: r = 1/4 + 3/4 exp(-t), E\\* = R = 1, depth 1 at t = 1 and back; λ = 3: w/E∞\\*R = 0.05, "
        "E∞/E0 = 0.1.",
        "\n".join([HEAD, *(row.line for row in rows)]),
        "## Sources",
        "\n".join(["| | |\n|---|---|", *(f"| {short} | {full} |" for short, full in SOURCES.items())]),
    ]
    return "\n\n".join(parts) + "\n", [row for row in rows if not row.difference <= row.tolerance]


if __name__ == "__main__":
    text, wrong = page()
    PAGE.write_text(text, encoding="utf-8")
    print(text)
    sys.exit("".join(f"beyond its tolerance: {row}\n" for row in wrong) or 0)
