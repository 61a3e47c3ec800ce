"""Schematics of the theory's page in the style of all figures, from the formulas themselves (`make gallery`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jkrcli.formulas import hertz, lagging, shift
from jkrcli.report.plots import BLACK, BLUE, GREEN, ORANGE, WIDE, Axes, panelled, save

SMALL = 8  # points
FINE = np.linspace(1e-6, 1, 201)


def draw(folder: Path) -> None:
    """The energies of JKR, contact radii of nodes, and a contact area that was measured on the sphere."""
    with panelled(WIDE, 2.5, 3, grid=False) as (figure, panels):
        for axes, panel in zip(panels, (energies, nodes, area), strict=True):
            panel(axes)
            axes.set(xticks=[], yticks=[])
        save(figure, [folder / "schematics.png"])


def energies(axes: Axes) -> None:
    """P over delta, E* = R = 1: pressed without adhesion to a, then moved back as a flat punch of that radius."""
    a, w = 1.0, 0.06
    delta_H, P_H = hertz(a * FINE, 1.0, 1.0)
    top = delta_H[-1], P_H[-1]
    end = lagging(*top, 2 * a, shift(w, a, 2.0))
    axes.fill_between(delta_H, P_H, color=BLUE, alpha=0.15, lw=0)
    axes.fill([end[0], *top[:1] * 2, end[0]], [end[1], top[1], 0, 0], color=ORANGE, alpha=0.25, lw=0)
    axes.plot(delta_H, P_H, color=BLUE)
    axes.plot([top[0], end[0]], [top[1], end[1]], color=ORANGE)
    for x, y, words, place in ((0.0, 0.0, "O", (-9, -3)), (*top, "A", (3, 2)), (*end, "B", (4, -7))):
        axes.plot(x, y, "o", color=BLACK, ms=3)
        axes.annotate(words, (x, y), place, textcoords="offset points")
    axes.text(0.02, 0.72, "$P_H(\\delta_H)$:\n$a$ grows", color=BLUE, fontsize=SMALL)
    axes.text(0.3, 1.2, "slope $S(a)$:\n$a$ stays", color=ORANGE, fontsize=SMALL)
    axes.set(xlabel="displacement $\\delta$", ylabel="load $P$", xlim=(-0.12, 1.15), ylim=(-0.1, 1.55))
    axes.set_title("(a) energies", fontsize=SMALL)


def nodes(axes: Axes) -> None:
    """The true edge over increments, and the outermost node in contact."""
    steps = np.arange(1, 25)
    true, element = np.sqrt(steps / steps[-1]), 0.15
    reported = element * np.floor(true / element)
    first = np.flatnonzero(np.diff(reported, prepend=0.0) > 0)
    for node in element * np.arange(1, 7):
        axes.axhline(node, color="0.85", lw=0.6)
    axes.plot(steps, true, color=BLUE)
    axes.step(steps, reported, where="post", color="0.5", lw=0.8)
    axes.plot(steps, reported, "o", color="0.5", ms=2.5)
    axes.plot(steps[first], reported[first], "o", color=ORANGE, ms=4)
    axes.text(2, 0.78, "true edge", color=BLUE, fontsize=SMALL)
    axes.text(9, 0.12, "outermost node:\nthe first of each\nis kept", color=ORANGE, fontsize=SMALL)
    axes.set(xlabel="increment", ylabel="contact radius $a$", ylim=(0, 1.1))
    axes.set_title("(b) radii of nodes", fontsize=SMALL)


def area(axes: Axes) -> None:
    """The cap of a sphere of radius R = 1 that is in contact: its area A, its radius a."""
    angle, a = np.linspace(-0.55, 0.55, 101) * np.pi, 0.62
    axes.plot(np.sin(angle), 1 - np.cos(angle), color="0.6")
    cap = np.arcsin(a) * np.linspace(-1, 1, 101)
    axes.plot(np.sin(cap), 1 - np.cos(cap), color=ORANGE, lw=3)
    depth = 1 - np.sqrt(1 - a**2)
    line: dict[str, Any] = {"color": BLACK, "lw": 0.8}
    axes.plot([0, 0], [0, 1], ls="--", **line)
    axes.plot([0, a], [1, depth], **line)
    axes.plot([0, a], [depth, depth], color=GREEN)
    letters = (("$R$", 0.36, 0.68, BLACK), ("$a$", 0.25, depth + 0.04, GREEN), ("$\\varphi$", 0.02, 0.66, BLACK))
    for words, x, y, color in (*letters, ("$A$", -0.82, 0.12, ORANGE)):
        axes.text(x, y, words, color=color)
    axes.set(aspect="equal", xlim=(-1.1, 1.1), ylim=(-0.2, 1.2), xlabel="radius $r$", ylabel="height")
    axes.set_title("(c) $A = 2\\pi R^2[1 - (1 - a^2/R^2)^{1/2}]$", fontsize=SMALL)
