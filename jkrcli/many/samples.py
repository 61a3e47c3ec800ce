"""Samples of measured curves: what each has of E* and w, and by how much they differ, from the table of a fit.

Moduli and works of adhesion are positive and scatter by factors: means, intervals and tests are those of their
logarithms. What curves have in common, as an error of the spring constant, does not become less with their number: it
stands apart from the interval of a mean. Of a ratio it leaves what it changes in one sample more than in the other:

    d ln(ratio)/dc = mean of d ln(q)/dc over one sample - that over the other
"""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base.errors import LEVEL, counted
from ..base.numerics import Array, f_quantile, half_width
from ..base.registry import Result
from ..base.units import scale
from ..report.result import Figure
from ..report.tables import transpose_rows, with_unit

QUANTITIES = {"E_star": "modulus", "w": "work", "w_approach": "work"}
SYMBOLS = {"E_star": "E*"}
FITTED = "fitted"
LEAST = 2  # theory: values of which a scatter follows
REASONS_SHOWN = 3  # choice: of a line
COMMON = ("calibration", "model")  # parts of the error that many curves may share


@dataclass(frozen=True)
class Spread:
    """A quantity over the ``n`` curves of a sample [SI]: ``median`` and ``quartiles``; geometric ``mean`` with
    ``interval``, None where a value is not positive or there is one alone; ``log_sd``: standard deviation of the
    logarithms; ``common``: relative half-widths of what the curves share, by its kind."""

    n: int
    median: float
    quartiles: tuple[float, float]
    mean: float | None
    interval: tuple[float, float] | None
    log_sd: float | None
    common: Mapping[str, float]


def spread_of(values: Array, common: Mapping[str, float], level: float) -> Spread:
    """The spread of ``values``, with relative half-widths of each kind of ``common`` error."""
    low, middle, high = (float(q) for q in np.quantile(values, (0.25, 0.5, 0.75)))
    if values.size < LEAST or not (values > 0).all():
        return Spread(values.size, middle, (low, high), None, None, None, common)
    # exp(mean(ln x) ± t s/sqrt(n))
    logs = np.log(values)
    sd, mean = float(logs.std(ddof=1)), float(logs.mean())
    half = _t(values.size - 1, level) * sd / math.sqrt(values.size)
    ends = math.exp(mean - half), math.exp(mean + half)
    return Spread(values.size, middle, (low, high), math.exp(mean), ends, sd, common)


@dataclass(frozen=True)
class Difference:
    """Of a ``sample`` from the sample ``against``: ``ratio`` of the geometric means and its ``interval`` by all
    ``parts`` of the error, half-widths by their kinds, the statistical one that of Welch; the standardised difference
    of the logarithms ``g`` (Hedges) and its ``g_interval``, None where nothing scatters; intervals hold for all pairs
    together at the level."""

    sample: str
    against: str
    ratio: float
    interval: tuple[float, float]
    parts: Mapping[str, float]
    g: float | None
    g_interval: tuple[float, float] | None


def difference(
    names: tuple[str, str], x: Array, y: Array, level: float, common: Mapping[str, float] | None = None
) -> Difference:
    """How the positive values ``x`` of one sample differ from ``y`` of the other; ``common``: relative half-widths, by
    kinds, of what errors of inputs and models leave of the ratio.

    Sources: Welch 1947 (unequal variances); Hedges and Olkin 1985, Sec. 5 (g, its variance).
    """
    logs, n = (np.log(x), np.log(y)), (x.size, y.size)
    step = float(logs[0].mean() - logs[1].mean())
    squares = [float(log.var(ddof=1)) / log.size for log in logs]
    dof = sum(squares) ** 2 / sum(s**2 / (m - 1) for s, m in zip(squares, n, strict=True)) if sum(squares) else 1.0
    parts = {"statistical": _t(dof, level) * math.sqrt(sum(squares)), **(common or {})}
    half, ratio = math.hypot(*parts.values()), math.exp(step)
    # g = J (mean difference)/(pooled standard deviation), J = 1 - 3/(4 nu - 1)
    nu = sum(n) - 2
    pooled = math.sqrt(sum((m - 1) * float(log.var(ddof=1)) for log, m in zip(logs, n, strict=True)) / nu)
    g, ends = None, None
    if pooled > 0:
        g = (1 - 3 / (4 * nu - 1)) * step / pooled
        reach = half_width(level) * math.sqrt(sum(n) / math.prod(n) + g**2 / (2 * sum(n)))
        ends = g - reach, g + reach
    each = {kind: ratio * math.sinh(part) for kind, part in parts.items()}
    return Difference(*names, ratio, (ratio * math.exp(-half), ratio * math.exp(half)), each, g, ends)


def shown(value: float) -> str:
    """A number with three digits: "0.984", "18.0", "202"."""
    return f"{value:#.3g}".rstrip(".") if 1e-3 <= abs(value) < 999.5 else f"{float(f'{value:.3g}'):.6g}"


def _t(dof: float, level: float) -> float:
    return math.sqrt(f_quantile(1, dof, level))


@dataclass(frozen=True, eq=False)
class Samples(Result):
    """Samples of a fit, by the column ``sample`` of its ``table``, in which ``kind`` is that of the reason why a curve
    is left out; ``causes``: of each row what errors of inputs and models change, relative half-widths with their sign
    by quantity, kind and cause. Those that are the same in all samples cancel in a ratio as far as they change these
    alike, others, ``own``, do not, as the radii of two tips."""

    table: Mapping[str, Sequence[Any]]
    causes: Sequence[Mapping[tuple[str, str, str], float]] = ()
    own: Collection[str] = ()

    @property
    def names(self) -> list[str]:
        """The samples in the order in which they were given."""
        return list(dict.fromkeys(self.table["sample"]))

    @property
    def level(self) -> float:
        """Of all intervals: that of the fits."""
        return next((one for one in self.table.get("level", ()) if one is not None), LEVEL)

    def rows(self, sample: str) -> list[int]:
        """The rows of a sample."""
        return [i for i, name in enumerate(self.table["sample"]) if name == sample]

    def believed(self, sample: str) -> list[int]:
        """Its rows that are fitted, whose values hold within their errors: the others are left out."""
        return [i for i in self.rows(sample) if self.table["status"][i] == FITTED]

    def left_out(self, sample: str) -> Counter[str]:
        """How many curves of the sample are left out for each reason."""
        return Counter(self.table["kind"][i] for i in self.rows(sample) if self.table["status"][i] != FITTED)

    def column(self, name: str, rows: Sequence[int], part: str = "") -> Array:
        """A quantity, or a ``part`` of its error, in SI at ``rows``; nan where there is none."""
        title = with_unit("_".join(filter(None, (name, part))), QUANTITIES[name])
        cells = self.table.get(title, ())
        return np.array([cells[i] if cells and cells[i] is not None else math.nan for i in rows], dtype=float)

    @cached_property
    def quantities(self) -> list[str]:
        """E* and w, of approaches alone w_approach, as far as curves have them."""
        rows = [row for name in self.names for row in self.believed(name)]
        found = [name for name in QUANTITIES if np.isfinite(self.column(name, rows)).any()]
        return [name for name in found if name != "w_approach" or "w" not in found]

    @cached_property
    def spreads(self) -> dict[str, dict[str, Spread]]:
        """For each quantity that of the samples which have any."""
        found: dict[str, dict[str, Spread]] = {name: {} for name in self.quantities}
        for name, sample in itertools.product(self.quantities, self.names):
            rows = [i for i in self.believed(sample) if np.isfinite(self.column(name, [i])).all()]
            if rows:
                found[name][sample] = spread_of(self.column(name, rows), self.common(name, sample), self.level)
        return found

    def common(self, name: str, *samples: str) -> dict[str, float]:
        """Relative half-widths, by their kinds, of what the curves of a sample have in common in a quantity, or of what
        is left of it in the ratio of two."""
        means = list[dict[tuple[str, str], float]]()
        for sample in samples if self.causes else ():
            rows = [i for i in self.believed(sample) if np.isfinite(self.column(name, [i])).all()]
            mean = defaultdict[tuple[str, str], float](float)
            for (quantity, kind, cause), change in (pair for i in rows for pair in self.causes[i].items()):
                if quantity == name:
                    mean[kind, cause] += change / len(rows)
            means.append(mean)
        left = dict[str, float]()
        for kind, cause in dict.fromkeys(key for mean in means for key in mean):
            first, *rest = (mean.get((kind, cause), 0.0) for mean in means)
            size = math.hypot(first, *rest) if cause in self.own else first - sum(rest)
            left[kind] = math.hypot(left.get(kind, 0.0), size)
        return left

    @cached_property
    def differences(self) -> dict[str, list[Difference]]:
        """For each quantity those of all pairs of samples; together their intervals hold at the level (Bonferroni)."""
        found: dict[str, list[Difference]] = {}
        for name, spreads in self.spreads.items():
            pairs = list(itertools.combinations([one for one in spreads if spreads[one].log_sd is not None], 2))
            level = 1 - (1 - self.level) / max(len(pairs), 1)
            found[name] = []
            for against, sample in pairs:
                values = [self.column(name, self.believed(one)) for one in (sample, against)]
                x, y = (one[np.isfinite(one)] for one in values)
                wider = half_width(level) / half_width(self.level)
                common = {kind: wider * part for kind, part in self.common(name, sample, against).items()}
                found[name].append(difference((sample, against), x, y, level, common))
        return found

    @property
    def columns(self) -> dict[str, list[Any]]:  # type: ignore[override]
        return transpose_rows([self._row(sample) for sample in self.names])

    def _row(self, sample: str) -> dict[str, Any]:
        left = self.left_out(sample)
        fitted = len(self.believed(sample))
        why = "; ".join(f"{count} {reason}" for reason, count in left.most_common())
        row: dict[str, Any] = {"sample": sample, "curves": fitted + left.total(), "fitted": fitted,
                               "left_out": left.total(), "why": why}  # fmt: skip
        for name, spreads in self.spreads.items():
            if (one := spreads.get(sample)) is None:
                continue
            low, high = one.interval or (None, None)
            values = {"median": one.median, "q1": one.quartiles[0], "q3": one.quartiles[1], "geomean": one.mean,
                      "low": low, "high": high}  # fmt: skip
            row |= {with_unit(f"{name}_{part}", QUANTITIES[name]): value for part, value in values.items()}
            row |= {f"{name}_{kind}_relative": share for kind, share in one.common.items()}
            first = [each for each in self.differences[name] if each.sample == sample][:1]
            for each in first:
                row |= {f"{name}_against": each.against, f"{name}_ratio": each.ratio}
                low, high = each.interval
                parts = {"err": (high - low) / 2, "low": low, "high": high, **each.parts}
                row |= {f"{name}_ratio_{part}": value for part, value in parts.items()}
                row |= {f"{name}_g": each.g}
                row |= dict(zip((f"{name}_g_low", f"{name}_g_high"), each.g_interval or (None, None), strict=True))
        return row | {"level": self.level}

    def summary(self) -> dict[str, Any]:
        """Of each sample its row, of each quantity the differences of all pairs."""
        rows = [{name: cell for name, cell in self._row(sample).items() if cell is not None} for sample in self.names]
        pairs = {name: [vars(one) for one in each] for name, each in self.differences.items()}
        return {"samples": rows, "differences": pairs}

    def words(self) -> list[str]:
        """A line on all curves, one on each sample, one on the ratio of each to the first."""
        every, fitted = Counter[str](), sum(len(self.believed(sample)) for sample in self.names)
        for sample in self.names:
            every += self.left_out(sample)
        reasons = [f"{count} {reason}" for reason, count in every.most_common(REASONS_SHOWN)]
        why = f", {every.total()} left out ({', '.join(reasons)}{', ...' * (len(every) > len(reasons))})" * bool(every)
        total = counted(fitted + every.total(), "curve")
        head = f"{counted(len(self.names), 'sample')}: {fitted} of {total} fitted{why}"
        wide = max(map(len, self.names))
        # The errors that curves share, where there are any, by their kinds
        kinds = []
        for kind in COMMON:
            shares = {name: max((one.common.get(kind, 0.0) for one in each.values()), default=0.0)
                      for name, each in self.spreads.items()}  # fmt: skip
            told = [f"± {100 * share:.2g} % of {SYMBOLS.get(name, name)}" for name, share in shares.items() if share]
            kinds += [f"{kind} {', '.join(told)}"] * bool(told)
        common = f"; beside these: {'; '.join(kinds)}" * bool(kinds)
        lines = [f"{head}; geometric means at {100 * self.level:g} %{common}"]
        for sample in self.names:
            values = []
            for name in (name for name in self.quantities if sample in self.spreads[name]):
                one, (factor, unit) = self.spreads[name][sample], self.unit(name)
                text = f"{shown(one.median / factor)} {unit} (median)"
                if one.mean is not None and one.interval is not None:
                    low, high = (shown(end / factor) for end in one.interval)
                    text = f"{shown(one.mean / factor)} ({low} to {high}) {unit}"
                values.append(f"{SYMBOLS.get(name, name)} = {text}")
            believed = len(self.believed(sample))
            of_all = f"{believed} of {believed + self.left_out(sample).total()}"
            lines.append(f"  {sample:<{wide}}  {of_all}: {', '.join(values)}")
        for sample in self.names[1:]:
            parts = [f"{SYMBOLS.get(name, name)} x {one.ratio:.2f} ({one.interval[0]:.2f} to {one.interval[1]:.2f})"
                     for name, each in self.differences.items() for one in each
                     if (one.sample, one.against) == (sample, self.names[0])]  # fmt: skip
            lines += [f"  {sample} over {self.names[0]}: {', '.join(parts)}"] * bool(parts)
        return lines

    def unit(self, name: str) -> tuple[float, str]:
        """The one unit in which a quantity is shown of all samples, in SI and as it is called."""
        return scale(max((abs(one.median) for one in self.spreads[name].values()), default=1.0), QUANTITIES[name])

    def figure(self, *names: str) -> Figure:
        """A box and all points of each sample, a panel for each quantity, or each of ``names``."""
        from .figures import boxes_figure

        drawn = {}
        for name in names or self.quantities:
            each = [self.column(name, self.believed(sample)) for sample in self.names]
            spreads = [self.spreads[name].get(sample) for sample in self.names]
            means = [(one.mean, *one.interval) if one and one.mean and one.interval else () for one in spreads]
            drawn[name.removesuffix("_approach")] = [*zip((values[np.isfinite(values)] for values in each), means,
                                                          strict=True)]  # fmt: skip
        return boxes_figure(self.names, drawn)
