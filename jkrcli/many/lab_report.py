"""A report of a fit: one self-contained page (HTML), and the same as Markdown, to print and to file with the data.

Question, specimen, calibration, samples, curves that were left out with their reasons, figures, and what it takes to
repeat the fit: command, versions, checksums of the files.
"""

from __future__ import annotations

import base64
import hashlib
import html
import platform
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from importlib.metadata import version
from pathlib import Path
from string import Template
from typing import Any, TypeAlias
from urllib.parse import quote

import numpy as np

from .. import __version__
from ..base.errors import counted
from ..report.result import SHOWN, Figure
from .samples import COMMON, FITTED, SYMBOLS, Samples, shown

PAGE = Template(resources.files(__package__).joinpath("lab_report.html").read_text(encoding="utf-8"))
LITTLE = 1e-3  # choice: of a ratio, a part of its error that is none
PACKAGES = ("numpy", "scipy", "h5py", "matplotlib")


@dataclass(frozen=True)
class Link:
    """Where a file beside the report is, in few ``words``, and what it ``holds``."""

    to: str
    words: str
    holds: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells under a line of ``names``; ``folded``: its words where it is shown on request, and in print."""

    names: Sequence[str]
    rows: Sequence[Sequence[str | Link]]
    folded: str = ""


@dataclass(frozen=True)
class Picture:
    """A PNG file of a figure, with what it shows in ``words``; ``width`` in which it is drawn [inch]."""

    content: bytes
    width: float
    words: str


Block: TypeAlias = str | Table | Link | Sequence[Picture]  # text: a paragraph
Sections: TypeAlias = Sequence[tuple[str, Sequence[Block]]]


@dataclass(frozen=True, eq=False)
class LabReport:
    """What a report is made of: the ``table`` of the fit, its ``samples`` if there are any, the specimen
    ``body`` in words, ``calibration`` and ``remarks`` in sentences, ``figures`` by what they show,
    the ``files`` that were read, the ``command``, and files beside the report with what they hold; ``page``: of these
    the one to click through the curves."""

    table: Mapping[str, Sequence[Any]]
    samples: Samples | None
    body: str
    calibration: Sequence[str]
    remarks: Sequence[str]
    figures: Mapping[str, Callable[[], Figure]]
    files: Sequence[Path]
    command: str
    beside: Mapping[str, str]
    page: str = ""

    @property
    def title(self) -> str:
        of = f" of {counted(len(self.samples.names), 'sample')}" if self.samples else ""
        return f"{counted(len(self.table['curve']), 'force curve')}{of}"

    @property
    def whole(self) -> Samples:
        """The samples; of curves without samples one of all."""
        count = len(self.table["curve"])
        return self.samples or Samples({"sample": ["all curves"] * count, **self.table})

    @cached_property
    def sections(self) -> Sections:
        """The report by its headings."""
        names = self.whole.names if self.samples else []
        differ = f", and whether they differ between {', '.join(names)}" if len(names) > 1 else ""
        from ..report import plots

        pictures = list[Picture]()
        with tempfile.TemporaryDirectory() as folder:
            for words, figure in self.figures.items():
                plots.save(drawn := figure(), [path := Path(folder) / "figure.png"])
                pictures.append(Picture(path.read_bytes(), float(drawn.get_figwidth()), words))
        shown: list[tuple[str, Sequence[Block]]] = [("Figures", [pictures])] if pictures else []
        versions = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
        sums = [[str(path), hashlib.sha256(path.read_bytes()).hexdigest()] for path in self.files]
        again: list[Block] = [self.command, f"jkr {__version__}, Python {platform.python_version()}, {versions}.",
                 Table(["file", "SHA-256"], sums, folded=f"Checksums of {counted(len(sums), 'file')}")]  # fmt: skip
        return [
            ("Question", [f"Reduced modulus E* and work of adhesion w of {self.title}{differ}."]),
            ("Specimen", [f"{self.body[:1].upper()}{self.body[1:]}."]),
            ("Calibration", self.calibration or ["No uncertainty of an input was given (--uncertain)."]),
            ("Results", self.results()),
            *shown,
            ("Left out", self.left_out()),
            *([("Remarks", list(self.remarks))] if self.remarks else []),
            ("Files", [Link(name, name, holds) for name, holds in self.beside.items()]),
            ("To repeat it", again),
        ]

    def results(self) -> list[Block]:
        """The table by sample, and the ratios of all pairs."""
        whole, level = self.whole, f"{100 * self.whole.level:g} %"
        blocks: list[Block] = [f"{whole.words()[0]}."] if self.samples else []
        for name, spreads in whole.spreads.items() if len(self.table["curve"]) > 1 else ():
            symbol, (factor, unit) = SYMBOLS.get(name, name), whole.unit(name)

            def words(*values: float | None, factor: float = factor) -> str:
                return " to ".join("" if value is None else shown(value / factor) for value in values)

            rows, pairs = list[list[str]](), list[list[str]]()
            for sample, one in spreads.items():
                ends = words(*one.interval) if one.interval else ""
                common = [f"{100 * one.common[kind]:.2g} %" if one.common.get(kind) else "not given" for kind in COMMON]
                quartiles = words(*one.quartiles)
                rows.append([sample, f"{one.n}", words(one.median), quartiles, words(one.mean), ends, *common])
            for each in whole.differences[name]:
                ratio, g = (
                    "{:.3g} to {:.3g}".format(*ends) if ends else "" for ends in (each.interval, each.g_interval)
                )
                size = "" if each.g is None else f"{each.g:.2g}"
                # half-widths, or that they are next to nothing
                sizes = [each.parts.get(kind) for kind in ("statistical", *COMMON)]
                least = LITTLE * each.ratio
                parts = ["" if one is None else f"{one:.2g}" if one > least else f"< {least:.1g}" for one in sizes]
                pairs.append([each.sample, each.against, f"{each.ratio:.3g}", *parts, ratio, size, g])
            heads = ["sample", "n", f"{symbol} ({unit}), median", "quartiles", "geometric mean", level]
            blocks.append(Table([*heads, *(f"{kind} ±" for kind in COMMON)], rows))
            of_pairs = [
                f"{symbol} of",
                "over",
                "ratio",
                *(f"{kind} ±" for kind in ("statistical", *COMMON)),
                f"{level}, all pairs together",
                "Hedges' g",
                f"{level}, all pairs",
            ]
            blocks += [Table(of_pairs, pairs)] * bool(pairs)
        return [*blocks, self.curves()]

    def curves(self) -> Table:
        """Each curve that was fitted: grade, value and interval by all parts of the error."""
        whole, names, rows = self.whole, ["curve", "grade"], list[list[str | Link]]()
        for name in whole.quantities:
            names += [f"{SYMBOLS.get(name, name)} ({whole.unit(name)[1]})", f"{100 * whole.level:g} %"]
        for i in (i for i, status in enumerate(self.table["status"]) if status == FITTED):
            row: list[str | Link] = [self._link(i), str(self.table["grade"][i] or "") if "grade" in self.table else ""]
            for name in whole.quantities:
                parts = (whole.column(name, [i], part)[0] / whole.unit(name)[0] for part in ("", "low", "high"))
                value, low, high = (shown(float(part)) if np.isfinite(part) else "" for part in parts)
                row += [value, f"{low} to {high}" if low or high else ""]
            rows.append(row)
        return Table(names, rows, folded="" if len(rows) <= SHOWN else f"All {len(rows)} curves that were fitted")

    def _link(self, row: int) -> str | Link:
        """The name of a curve, which leads to its place on the page of all curves."""
        name = str(self.table["curve"][row])
        return Link(f"{self.page}#{row + 1}", name) if self.page else name

    def left_out(self) -> list[Block]:
        """Each curve that is not in the results, with the reason, and its place on the page of all curves."""
        table, rows = self.table, list[list[str | Link]]()
        for i in (i for i, status in enumerate(table["status"]) if status != FITTED):
            rows.append([str(table["file"][i]), self._link(i), str(table["reason"][i])])
        return [Table(["file", "curve", "reason"], rows)] if rows else ["No curve."]

    def as_html(self) -> str:
        """The page, whole in one file."""
        parts = (f"<section><h2>{html.escape(title)}</h2>{''.join(map(_html, blocks))}</section>"
                 for title, blocks in self.sections)  # fmt: skip
        return PAGE.substitute(title=html.escape(self.title), body="\n".join(parts), version=__version__)

    def as_markdown(self) -> str:
        """The same in Markdown, which refers to the pictures beside it."""
        pictures = "\n".join(f"![{holds}]({name})" for name, holds in self.beside.items() if name.endswith(".png"))
        parts = (f"## {title}\n\n" + "\n\n".join(filter(None, (_markdown(block) or pictures for block in blocks)))
                 for title, blocks in self.sections)  # fmt: skip
        return "\n\n".join([f"# {self.title}", *parts, f"<!-- jkr {__version__} -->\n"])


def _html(block: Block) -> str:
    if isinstance(block, str):
        return f"<p>{html.escape(block)}</p>"
    if isinstance(block, Link):
        return f"<p>{_cell(block)}: {html.escape(block.holds)}</p>"
    if isinstance(block, Table):
        head = "".join(f"<th>{html.escape(name)}</th>" for name in block.names)
        rows = "".join(f"<tr>{''.join(f'<td>{_cell(cell)}</td>' for cell in row)}</tr>\n" for row in block.rows)
        table = f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'
        return f"<details><summary>{html.escape(block.folded)}</summary>{table}</details>" if block.folded else table
    pictures = (f'<figure><img width="{96 * one.width:.0f}" alt="{html.escape(one.words)}" src="data:image/png;base64,'
                f'{base64.b64encode(one.content).decode()}"><figcaption>{html.escape(one.words)}</figcaption></figure>'
                for one in block)  # fmt: skip
    return f'<div class="figures">{"".join(pictures)}</div>'


def _cell(cell: str | Link) -> str:
    if isinstance(cell, str):
        return html.escape(cell)
    return f'<a href="{html.escape(quote(cell.to, safe="#/"))}">{html.escape(cell.words)}</a>'


def _markdown(block: Block) -> str:
    if isinstance(block, str):
        return block
    if isinstance(block, Link):
        return f"- [{block.words}]({block.to}): {block.holds}"
    if not isinstance(block, Table):
        return ""
    rows = ([cell if isinstance(cell, str) else f"[{cell.words}]({cell.to})" for cell in row] for row in block.rows)
    lines = [f"| {' | '.join(block.names)} |", f"|{' --- |' * len(block.names)}"]
    return "\n".join([*lines, *("| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in rows)])
