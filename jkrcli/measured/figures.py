"""Figures of a fit: the curve over its data, the residuals along it, the joint confidence region of E* and w; of
records fitted together, all of them from their own zeros, each with the curve that they share; of fitted laws of w over
speed and of relaxation, the records beside the model.
"""

import math
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from ..base.errors import Unknown
from ..base.numerics import DRAWN, Array
from ..base.units import show
from ..report import plots
from ..report.plots import Axes, Figure, axis_of, enlarged, log_ends, log_ticks, panelled, pretty, unit_of
from .archive import DOUBTFUL, FITTED, IMAGES, STATUSES, UNUSABLE, Map, status_of
from .joint import JointFit
from .least_squares import chi2_increase
from .procedure import Failure
from .result import Fit
from .segmentation import Direction, ForceCurve
from .work import WorkAlong, typical

AXES = {"delta,P": ("delta", "P"), "a,P": ("P", "a"), "a,delta": ("delta", "a"), "a,delta,P": ("delta", "P")}
STATUS_LOOKS = {FITTED: (plots.BLUE, "o"), DOUBTFUL: (plots.ORANGE, "^"), UNUSABLE: (plots.BLACK, "x")}
BRANCH_GAP = 0.3  # choice: of the largest contact radius, a step of the fitted line beyond which it is not joined
ARROW_ROWS = 8  # choice: fewest rows of a branch in contact for an arrow
MARKS = {"a": (plots.GREEN, "s"), "delta": (plots.BLUE, "^"), "P": (plots.ORANGE, "o")}
GREY_CELL = "0.8"  # choice: of a map's place without a value, which no colour of the scale is
PROFILED = 3  # choice: values of which a profile line is drawn
MARKERS = 300  # choice: measured points that are drawn; more hide the line


def fit_figure(fit: Fit) -> Figure:
    """Three panels, or two where the data tell no joint region of E* and w."""
    region = fit.covariance is not None and {"modulus", "w"} <= set(fit.free)
    with panelled(plots.WIDE if region else plots.MIDDLE, 2.8, 3 if region else 2, legend=5) as (figure, panels):
        _curve(panels[0], fit)
        _residuals(panels[1], fit)
        if region:
            _region(panels[2], fit)
        return figure


def _curve(axes: Axes, fit: Fit) -> None:
    x, y = AXES[",".join(fit.data)]
    units, labels = zip(*(axis_of(name, fit.data[name]) for name in (x, y)), strict=True)
    measured = [fit.data[name] / unit for name, unit in zip((x, y), units, strict=True)]
    places = [axes]
    touched = fit.a > 0
    if touched.any() and np.ptp(measured[0][touched]) < plots.LARGER * np.ptp(measured[0]):
        across, up = measured
        level = (float(np.median(up[~touched])) - up.min()) / np.ptp(up)
        places.append(enlarged(axes, across[touched], up[touched], 0.05 + 0.9 * level))
    for place in places:
        thin = 1 + fit.a.size // MARKERS
        place.plot(*(values[::thin] for values in measured), "o", color=plots.SKY, ms=3, mfc="none", label="measured")
        for label, colour, rows in _branches(fit):
            line = [np.where(rows, fit.line[name], np.nan) / unit for name, unit in zip((x, y), units, strict=True)]
            place.plot(*_broken(fit.line["a"], line), "-", color=colour, lw=1.2, label=label)
            if label != "fitted" and place is places[-1]:
                _arrow(place, line, np.where(rows, fit.line["a"], np.nan), colour)
    axes.set(xlabel=labels[0], ylabel=labels[1])


def _branches(fit: Fit) -> list[tuple[str, str, Array]]:
    """Label, colour and rows of approach and retraction along the fitted line, or of the line as a whole."""
    a, near, place = fit.line["a"], _near_rows(fit), np.arange(fit.line["a"].size)
    if fit.sizes is None:  # a table: the contact line closes up to the reversal, is pinned, then opens
        stops = np.flatnonzero((np.diff(a) <= 0) & (a[:-1] > 0))
        turn = int(stops[0]) if stops.size else a.size
    else:
        turn = _reversal(fit, a)
    if not 0 < turn < a.size - 1:
        return [("fitted", plots.BLACK, near)]
    return [
        ("fitted, approach", plots.BLUE, near & (place <= turn)),
        ("fitted, retraction", plots.ORANGE, near & (place >= turn)),
    ]


def _reversal(fit: Fit, a: Array) -> int:
    """The first row of the retraction of a raw force curve of radii ``a``: its rows are in the order of time."""
    return int(np.argmax(a)) if "approach" in fit.directions or not fit.directions else 0


def _broken(a: Array, line: Sequence[Array]) -> list[Array]:
    """The fitted ``line`` without its jumps: a gap where contact begins or ends, or the next branch begins."""
    begins = np.diff((a > 0).astype(int)) != 0
    gaps = np.flatnonzero(begins | (np.abs(np.diff(a)) > BRANCH_GAP * np.max(a))) + 1
    return [np.insert(column, gaps, np.nan) for column in line]


def _arrow(axes: Axes, line: Sequence[Array], a: Array, colour: str) -> None:
    """An arrow in the middle of a branch: towards larger contact radii on approach, smaller ones on retraction."""
    rows = np.flatnonzero(a > 0)
    if rows.size < ARROW_ROWS:
        return
    middle = rows[np.argmin(np.abs(a[rows] - 0.7 * a[rows].max()))]  # choice: where branches are apart and not steep
    others = rows[np.abs(a[rows] - a[middle]) > 0.02 * a[rows].max()]  # choice: long enough for its direction
    if others.size == 0:
        return
    other = others[np.argmin(np.abs(others - middle))]
    begin, end = (middle, other) if (a[other] > a[middle]) == (colour == plots.BLUE) else (other, middle)
    tail, head = ((float(line[0][row]), float(line[1][row])) for row in (begin, end))
    axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.2, "mutation_scale": 9})


def _near_rows(fit: Fit) -> Array:
    """Where the fitted line runs along the rows, not far beyond them."""
    return fit.line["a"] <= 1.02 * fit.a.max()


def _residuals(axes: Axes, fit: Fit) -> None:
    """Residuals of a table over the contact radius, of all rows of a raw force curve over the displacement."""
    scatter = fit.scatter or 1.0
    axes.axhline(0, color="0.6", lw=0.8, zorder=0)
    axes.set_ylabel("residual / standard deviation")
    if fit.sizes is not None:  # all scatter is in the load
        factor, label = axis_of("delta", fit.data["delta"])
        turn = _reversal(fit, fit.a)
        for colour, rows in ((plots.BLUE, slice(None, turn)), (plots.ORANGE, slice(turn, None))):
            axes.plot(fit.data["delta"][rows] / factor, fit.residuals[0, rows] / scatter, ".", color=colour, ms=1.5)
        axes.set_xlabel(label)
        return
    factor, label = axis_of("a", fit.a)
    names = ["normal distance"] if fit.residuals.shape[0] == 1 else [plots.LABELS[name] for name in fit.data]
    marks = [MARKS["delta"]] if len(names) == 1 else [MARKS[name] for name in fit.data]
    for values, name, (colour, mark) in zip(fit.residuals, names, marks, strict=True):
        axes.plot(fit.a / factor, values / scatter, mark, color=colour, ms=3, mfc="none", label=name)
    axes.set_xlabel(label)


def _region(axes: Axes, fit: Fit) -> None:
    """Border of the joint region of E* and w from the covariance; the bootstrap's values where there are any."""
    rows = [fit.free.index(name) for name in ("modulus", "w")]
    assert fit.covariance is not None
    covariance = fit.covariance[np.ix_(rows, rows)]
    (E_unit, E_label), (w_unit, w_label) = (axis_of(name, fit.value(name)) for name in ("E_star", "w"))
    factor = fit.value("E_star") / fit.value("modulus") / E_unit
    if fit.samples is not None:
        E, w = fit.samples[:, rows[0]] * factor, fit.samples[:, rows[1]] / w_unit
        axes.plot(E, w, ".", color="0.6", ms=2, label="bootstrap")
    radius = np.sqrt(fit.dof * chi2_increase(fit.settings.level, fit.dof, 2))
    # Points of the ellipse that lies `radius` standard deviations around zero.
    angle = np.linspace(0, 2 * np.pi, 200)
    size = np.sqrt(np.diag(covariance))
    root = np.linalg.cholesky(covariance / np.outer(size, size) + 1e-14 * np.eye(2))
    E, w = radius * size[:, None] * (root @ np.stack([np.cos(angle), np.sin(angle)]))
    E, w = (fit.value("modulus") + E) * factor, (fit.value("w") + w) / w_unit
    axes.plot(E, w, "-", color=plots.ORANGE, label=f"{fit.settings.level * 100:g} % region (statistical)")
    axes.plot(fit.value("E_star") / E_unit, fit.value("w") / w_unit, "+", color=plots.BLUE, ms=8)
    axes.set(xlabel=E_label, ylabel=w_label)
    axes.ticklabel_format(useOffset=False)
    axes.xaxis.set_major_locator(MaxNLocator(4))


def joint_figure(joint: JointFit) -> Figure:
    """All records over their fitted curves."""
    x, y = AXES[",".join(joint.fits[0].data)]
    together = [one for one in joint.fits if {x, y} <= set(one.data)]
    factors, labels = zip(*(
        axis_of(name, *(np.ptp(one.data[name][one.a > 0]) for one in together)) for name in (x, y)
    ), strict=True)  # fmt: skip
    with panelled(plots.MIDDLE, 2.8, legend=4) as (figure, [axes]):
        for i, one in enumerate(together):
            found = {item.name: item.value for item in one.estimates}
            zeros = [found.get({"delta": "delta0", "P": "P0"}.get(name, ""), 0.0) for name in (x, y)]
            near = [one.data[name][one.a > 0] for name in (x, y)]
            touching = (one.line["a"] > 0) & _near_rows(one)
            line = [np.where(touching, one.line[name], np.nan) for name in (x, y)]
            read, curve = ([(v - o) / f for v, o, f in zip(p, zeros, factors, strict=True)] for p in (near, line))
            axes.plot(*read, "o", color=plots.COLORS[i % len(plots.COLORS)], ms=3, mfc="none", label=pretty(one.name))
            label = "fitted" if one is together[-1] else None
            axes.plot(*_broken(one.line["a"], curve), "-", color=plots.BLACK, lw=1.0, label=label)
        axes.set(xlabel=labels[0], ylabel=labels[1])
        return figure


# --------------------------------------------------------------------------------------------------
# The figure of a map: an image per quantity, one cell per pixel, pixels without a value grey.


def map_figure(scan: Map) -> Figure:
    """Six images with a bar of their scale where positions are known, and under them E* along the middle row and
    column; else over columns and rows."""
    lines = _profiles(scan) if scan.positions else []
    height, count = 6.2 if lines else 4.2, len(scan.images) + len(lines)
    with panelled(plots.WIDE, height, count, columns=3, grid=False) as (figure, panels):
        for i, (panel, (name, image)) in enumerate(zip(panels, scan.images.items(), strict=False)):
            _image(figure, panel, scan, name, image)
            if scan.positions:
                panel.set(xticks=[], yticks=[])
                # A bar of a round length, a quarter of the map's width or more, under the image
                low, high = panel.get_xlim()
                ten = 10.0 ** math.floor(math.log10((high - low) / 4))
                bar = next(n * ten for n in (2, 5, 10) if n * ten >= (high - low) / 4)
                place: dict[str, Any] = {"transform": panel.get_xaxis_transform(), "clip_on": False}
                panel.plot([low, low + bar], [-0.05, -0.05], color=plots.BLACK, lw=2, solid_capstyle="butt", **place)
                panel.text(low + bar * 1.05, -0.05, pretty(show(bar, "length", 2)), va="center", size=8, **place)
                continue
            panel.set_xlabel("column" if i + 3 >= len(scan.images) else "")
            panel.set_ylabel("row" if i % 3 == 0 else "")
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_major_locator(MaxNLocator(4, integer=True))
        for panel, (title, at, values, ends) in zip(panels[len(scan.images) :], lines, strict=True):
            (length, of_length), (factor, unit) = unit_of("length", at), unit_of("modulus", values[np.isfinite(values)])
            panel.plot(at / length, values / factor, "o-", color=plots.BLUE, ms=3, lw=1.0)
            panel.set(title=title, xlabel=f"distance ({of_length})", ylabel=f"{plots.LABELS['E_star']} ({unit})")
            panel.ticklabel_format(useOffset=False)
            panels[0].plot(*ends, ":", color="white", lw=1.0)
        return figure


def _profiles(scan: Map) -> list[tuple[str, Array, Array, tuple[Array, Array]]]:
    """E* over the distance [m] along the row and the column nearest to the middle that hold enough values, with the
    ends of the line in the image; places without a value leave gaps."""
    x, y, image = scan.x - scan.x[0], scan.y - scan.y[0], scan.images["E_star"]
    lines = list[tuple[str, Array, Array, tuple[Array, Array]]]()
    for what, at, across, values in (("row", x, y, image), ("column", y, x, image.T)):
        held = np.flatnonzero(np.isfinite(values).sum(axis=1) >= PROFILED)
        for line in held[np.argsort(np.abs(held - across.size // 2), kind="stable")][:1]:
            place = f"the middle {what}" if line == across.size // 2 else f"{what} {line + 1}"
            ends, level = at[[0, -1]], np.full(2, across[line])
            lines.append((f"along {place}", at, values[line], (ends, level) if what == "row" else (level, ends)))
    return lines


def curves_figure(outcomes: Sequence[Fit | Failure]) -> Figure:
    """E* and w of curves without a grid over their numbers, with intervals, by their status; what is unusable along the
    axis."""
    numbers = np.arange(1, len(outcomes) + 1)
    status = np.array([status_of(item) for item in outcomes])
    with panelled(plots.WIDE, 4.6, 2, columns=1, legend=len(STATUS_LOOKS)) as (figure, panels):
        for axes, name in zip(panels, ("E_star", "w"), strict=True):
            found = [None if isinstance(item, Failure) else item.work if name == "w" else item.estimate(name)
                     for item in outcomes]  # fmt: skip
            rows = [(math.nan,) * 3 if one is None else (one.value, one.low, one.high) for one in found]
            value, low, high = np.array(rows, dtype=float).T
            factor, unit = unit_of(IMAGES[name], value[np.isfinite(value)])
            for word, (color, mark) in STATUS_LOOKS.items():
                at = status == word
                if word == UNUSABLE:
                    axes.plot(numbers[at], np.zeros(at.sum()), mark, color=color, label=word, clip_on=False,
                              transform=axes.get_xaxis_transform(), in_layout=False)  # fmt: skip
                    continue
                axes.vlines(numbers[at], low[at] / factor, high[at] / factor, color=color, lw=0.8)
                axes.plot(numbers[at], value[at] / factor, mark, color=color, label=word, ms=3)
            least, most = np.nanmin(value) / factor, np.nanmax(value) / factor
            usual = float(np.nanmedian(high - low)) / factor  # a long interval does not flatten the rest
            room = max(0.1 * (most - least), usual) or 0.1 * abs(most) or 1.0
            axes.set_ylim(least - room, most + room)
            axes.ticklabel_format(axis="y", useOffset=False)
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            axes.set_ylabel(f"{'$w$' if name == 'w' else plots.LABELS[name]} ({unit})")
        panels[-1].set_xlabel("curve")
        return figure


def _image(figure: Figure, axes: Axes, scan: Map, name: str, image: Array) -> None:
    """The ``image`` of one quantity; places without a value are grey."""
    known = image[np.isfinite(image)]
    factor, unit = (1.0, "") if IMAGES[name] == "number" else unit_of(IMAGES[name], known if known.size else 1.0)
    unknown = name == "quality" or not known.size
    # single pixels do not flatten the rest
    ends = (0.0, 2.0) if name == "status" else (0.0, 1.0) if unknown else np.percentile(known / factor, (2, 98))
    x, y = (scan.x - scan.x[0], scan.y - scan.y[0]) if scan.positions else (scan.x, scan.y)
    pitch = max(np.ptp(at) / (at.size - 1) for at in (x, y) if at.size > 1)
    cells = []  # edges of cells around the places; of a single one as far apart as those of the other axis
    for at in (x, y):
        inner = (at[1:] + at[:-1]) / 2
        outer = [2 * at[i] - inner[i] for i in (0, -1)] if at.size > 1 else [at[0] - pitch / 2, at[0] + pitch / 2]
        cells.append(np.concatenate([outer[:1], inner, outer[1:]]))
    axes.set_facecolor(GREY_CELL)
    drawn = axes.pcolormesh(*cells, image / factor, shading="flat", cmap="viridis",
                            vmin=ends[0], vmax=ends[1], rasterized=True)  # fmt: skip
    bar = figure.colorbar(drawn, ax=axes, format=ScalarFormatter(useOffset=False))
    bar.locator = MaxNLocator(4)
    if name == "status":
        bar.set_ticks(range(len(STATUSES)), labels=STATUSES)
    label = "$w$" if name == "w" else plots.LABELS.get(name, name.replace("_", " "))
    axes.set_title(f"{label} ({unit})" if unit else label)
    axes.set_aspect("equal")


# --------------------------------------------------------------------------------------------------
# Figures of measured records: directions, base lines, touch, jumps and adhesion as they were found.

LETTERS = round(plots.WIDE * 72 / 6)  # of a line as wide as the figure; theory: one of 9 points is 6 wide, with its gap
LOOKS, GREY = {"approach": (plots.BLUE, 2.0), "retract": (plots.ORANGE, 0.9)}, "0.6"  # the last drawn the thinnest


def record_figure(records: Sequence[ForceCurve]) -> Figure:
    """Load over displacement, a panel per curve; of many curves twelve spread evenly.

    All panels have the same units, told once along each side of the figure.
    """
    every = np.unique(np.linspace(0, len(records) - 1, min(len(records), 12)).round().astype(int))
    shown = [records[i] for i in every]
    columns = math.ceil(math.sqrt(len(shown)))
    rows = math.ceil(len(shown) / columns)
    x, length = unit_of("length", *(record.curve.device for record in shown))
    y, load = unit_of("load", *(record.curve.load for record in shown))
    with panelled(plots.WIDE, max(3.6, 2.2 * rows + 0.6), len(shown), columns, legend=4) as (figure, panels):
        for i, (panel, record) in enumerate(zip(panels, shown, strict=False)):
            _panel(panel, record, x, y, round(LETTERS / columns))
            what = "displacement" if record.curve.stiffness is None else "position z of the cantilever"
            panel.set_xlabel(fill(f"{what} ({length})", LETTERS // columns) if i + columns >= len(shown) else "")
            panel.set_ylabel(f"load ({load})" if i % columns == 0 else "")
        return figure


def _panel(axes: Axes, record: ForceCurve, x: float, y: float, letters: int) -> None:
    """One record, lengths in ``x`` [m], loads in ``y`` [N], under a title of lines of up to so many ``letters``."""
    curve = record.curve
    assert curve.P is not None
    z = curve.device
    places, touches = [axes], [item.touch for item in record.directions if isinstance(item.touch, float)]
    # The rows from the outermost touch on are drawn once more, larger, where the free way is long: there is room in a
    # panel of the whole width
    if letters == LETTERS and touches and z.max() - min(touches) < plots.LARGER * np.ptp(z):
        near = z >= min(touches)
        level = (float(np.median(curve.P[~near])) - curve.P.min()) / np.ptp(curve.P)
        places.append(enlarged(axes, z[near] / x, curve.P[near] / y, 0.05 + 0.9 * level))
    # The loads [N] of a record, the line through them broken at its jumps: the row before the steepest step is nan.
    broken = curve.P.copy()
    for row in [jump.row for item in record.directions for jump in (*item.jumps, *item.steps)]:
        first = max(row - 3, 0)
        broken[first + int(np.argmax(np.abs(np.diff(curve.P[first : row + 3 + 1]))))] = np.nan
    for place in places:
        for segment in record.segments:
            thin = slice(segment.first, segment.last + 1, 1 + len(segment) // DRAWN)
            colour, width = LOOKS.get(segment.kind, (GREY, 1.0))
            place.plot(z[thin] / x, broken[thin] / y, lw=width, label=segment.kind, color=colour)
        for item in record.directions:
            _marks(place, item, z[item.segment.rows], x, y)
    title = ": ".join([curve.name, ", ".join(record.flags)]).rstrip(": ")
    axes.set_title(fill(title, letters, max_lines=3, placeholder=" …"), loc="left", fontsize="small")


def _marks(axes: Axes, item: Direction, position: Array, x: float, y: float) -> None:
    """Base line, touch, adhesion and jumps of one direction; lengths in ``x`` [m], loads in ``y`` [N]."""
    if not item.based:
        return
    ends = np.array([position.min(), position.max()])
    axes.plot(ends / x, item.base(ends) / y, color=plots.BLACK, ls="--", lw=0.7, label="base line")
    if not isinstance(item.touch, Unknown):
        level = float(item.base(np.array(item.touch)))
        axes.errorbar(item.touch / x, level / y, xerr=item.touch_err / x, fmt="o", ms=4, mfc="none", color=plots.BLACK,
                      label="contact begins or ends")  # fmt: skip
    if not isinstance(item.adhesion, Unknown):
        level = float(item.base(np.array(item.adhesion_at))) - item.adhesion
        axes.plot(item.adhesion_at / x, level / y, "v", ms=5, color=plots.BLACK, mfc="none", label="adhesion force")
    for jump in item.jumps:
        axes.axvline(jump.position / x, color=plots.PURPLE, lw=0.8, ls=":", label="jump")


# --------------------------------------------------------------------------------------------------
# Figures of the work of adhesion along measured curves.

# told apart in grey too
GROUPS = {"measured": (plots.GREEN, "o"), "advancing": (plots.BLUE, "^"), "receding": (plots.ORANGE, "v")}


def work_figure(curves: Sequence[WorkAlong], law: Any = None) -> Figure:
    """w over the contact radius; where time was recorded also over the speed of the contact's edge, both logarithmic.

    Points are the rows of all curves, those whose contact line closes and opens told apart; a ``law`` has its band.
    """
    groups = _groups(curves)
    timed = "measured" not in groups
    width, count, legend = (plots.WIDE, 2, 3) if timed else (plots.NARROW, 1, 0)
    with panelled(width, 3.0, count, legend=legend) as (figure, axes):
        w, label = axis_of("w", typical(curves))
        a, radius_label = axis_of("a", *(rows["a"] for rows in groups.values()))
        for name, rows in groups.items():
            colour, marker = GROUPS[name]
            errors = rows["w_err"] / w if "w_err" in rows else None
            axes[0].errorbar(rows["a"] / a, rows["w"] / w, errors, fmt=marker, color=colour, ms=3, mfc="none",
                             elinewidth=0.5, ecolor="0.75", label=name)  # fmt: skip
        largest = max(float(np.quantile(rows["w"], 0.99)) for rows in groups.values())  # outliers may lie above
        axes[0].set(xlabel=radius_label, ylim=(0, 1.3 * largest / w))
        if timed:
            _over_speed(axes[1], groups, w, law)
        for panel in axes:
            panel.set_ylabel(label)
        return figure


GROUPS_MOST = 3000  # choice: rows of a group that are drawn


def _groups(curves: Sequence[WorkAlong]) -> dict[str, dict[str, Array]]:
    """The columns of the usable rows of all curves, by the sense of the edge's motion where any is known."""
    rows: dict[str, list[Array]] = {"advancing": [], "receding": []}
    for item in curves:
        if item.speed is not None and item.timed is not None:
            for name, sense in (("advancing", item.speed > 0), ("receding", item.speed < 0)):
                rows[name].append(item.timed & sense)
    if not any(mask.any() for masks in rows.values() for mask in masks):
        rows = {"measured": [item.ok for item in curves]}
    groups = {}
    for group, masks in rows.items():
        every, columns = 1 + sum(int(mask.sum()) for mask in masks) // GROUPS_MOST, dict[str, Array]()
        for name in ("a", "w", "w_err", "speed"):
            values = [getattr(item, name) for item in curves]
            if all(column is not None for column in values):
                columns[name] = np.concatenate([v[mask] for v, mask in zip(values, masks, strict=True)])[::every]
        if columns["w"].size:
            groups[group] = columns
    return groups


def _over_speed(axes: Axes, groups: Mapping[str, Mapping[str, Array]], w: float, law: Any) -> None:
    speed, unit = unit_of("length", *(rows["speed"] for rows in groups.values()))
    for name, rows in groups.items():
        colour, marker = GROUPS[name]
        axes.loglog(np.abs(rows["speed"]) / speed, rows["w"] / w, marker, color=colour, ms=3, mfc="none")
    if law is not None:
        slowest, fastest = law.speeds
        v = np.geomspace(slowest, fastest, 100)
        middle, low, high = law.band(v)
        axes.fill_between(v / speed, low / w, high / w, color=plots.BLACK, alpha=0.2, lw=0)
        axes.loglog(v / speed, middle / w, color=plots.BLACK, label="power law")
    axes.set_xlim(*log_ends(np.concatenate([np.abs(rows["speed"]) / speed for rows in groups.values()])))
    axes.set_ylim(*log_ends(np.concatenate([rows["w"] / w for rows in groups.values()])))
    log_ticks(axes.xaxis, axes.yaxis)
    axes.set_xlabel(f"{plots.LABELS['speed']} ({unit}/s)")
