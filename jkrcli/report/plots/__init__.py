"""Figures in one style, fit for print, and the one door to matplotlib: no pyplot, no global state, no clock."""

import contextlib
import logging
import os
import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from ... import __version__
from ...base import process
from ...base.errors import InputError, printable
from ...base.files import atomic
from ...base.numerics import Array
from ...base.units import scale
from ..tables import DIMENSIONS

# --------------------------------------------------------------------------------------------------
# What figures share: widths, colours, and the words and units of axes.

WIDE, MIDDLE, NARROW = 7.0, 4.8, 3.4  # two columns of a journal, one and a half, one [inch]: printed unscaled
LARGER = 0.3  # choice: of the way of a record, below which its contact is drawn once more, larger
# Okabe and Ito's palette: told apart by colour-blind readers, and by line style or marker in grey.
BLUE, ORANGE, GREEN, BLACK = "#0072B2", "#D55E00", "#009E73", "#000000"
PURPLE, SKY = "#CC79A7", "#56B4E9"
LABELS = {
    "delta": r"displacement $\delta$", "P": "load $P$", "a": "contact radius $a$", "t": "time $t$",
    "w": "work of adhesion $w$", "E_star": "$E^*$", "speed": "speed of the contact's edge $|da/dt|$",
}  # fmt: skip
COLORS = (BLUE, ORANGE, GREEN, PURPLE, SKY, BLACK)


def pretty(text: str) -> str:
    """Units as they are typeset."""
    return re.sub(r"\bu(?=[mNJ]\b)", "µ", text.replace("^2", "²"))


def unit_of(dimension: str, *values: Array | float) -> tuple[float, str]:
    """The unit that the largest of ``values`` [SI] asks for, in SI and as it is typeset."""
    factor, unit = scale(max(float(np.max(np.abs(each))) for each in values), dimension)
    return factor, pretty(unit)


def axis_of(name: str, *values: Array | float) -> tuple[float, str]:
    """The unit of an axis of the quantity ``name``, as ``unit_of``, and the axis' label."""
    factor, unit = unit_of(DIMENSIONS[name], *values)
    return factor, f"{LABELS[name]} ({unit})"


# --------------------------------------------------------------------------------------------------
# matplotlib's import without the lists of properties that it writes into its own docstrings and signatures, a quarter
# of its time, and, in the process ``jkr``, without what its surroundings say: no figure depends on it.


def _properties() -> Any:
    """matplotlib.artist; InputError where a matplotlibrc is in the way."""
    if process.runs():
        os.environ.pop("MPLBACKEND", None)  # one that is unknown is an error
        logging.getLogger("matplotlib").setLevel(logging.ERROR)  # of lines in a matplotlibrc, folders for caches
    try:
        from matplotlib import artist
    except UnicodeDecodeError as error:
        raise InputError(
            f"matplotlibrc: matplotlib cannot read it ({error}); mend or remove the one in this folder, or that of "
            "MATPLOTLIBRC"
        ) from None
    return artist


properties = _properties()


@contextlib.contextmanager
def without_tables() -> Iterator[None]:
    """What is imported here has none in the process ``jkr``, which shows none; elsewhere nothing is changed."""
    tables, setters = properties.kwdoc, properties.ArtistInspector.get_setters
    if process.runs():
        properties.kwdoc = lambda artist: ""
        properties.ArtistInspector.get_setters = lambda self: []
    try:
        yield
    finally:
        properties.kwdoc, properties.ArtistInspector.get_setters = tables, setters


with without_tables():
    import matplotlib as mpl
    from matplotlib.axes import Axes as Axes
    from matplotlib.axis import Axis
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure as Figure
    from matplotlib.text import Text
    from matplotlib.textpath import text_to_path
    from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter
    from matplotlib.transforms import ScaledTranslation
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

process.loaded()
DPI = 300  # choice: of PNG files
STYLE = dict(mpl.rc_params_from_file(Path(__file__).with_name("jkr.mplstyle"), use_default_template=False))
Box: TypeAlias = tuple[float, float, float, float]  # left, bottom, width, height, of the axes


def colors(count: int) -> Sequence[Any]:
    """Colours of ``count`` lines: the palette, or one that runs from dark to light where they are more."""
    return COLORS if count <= len(COLORS) else list(mpl.colormaps["viridis"](np.linspace(0, 0.9, count)))


@contextlib.contextmanager
def style(changes: dict[Any, Any] | None = None) -> Iterator[None]:
    """The settings of all figures, with ``changes``; none is taken from a matplotlibrc, wherever that lies."""
    defaults = {name: value for name, value in mpl.rcParamsDefault.items() if name != "backend"}
    with mpl.rc_context(defaults | STYLE | (changes or {})):
        yield


@contextlib.contextmanager
def drawing(
    width: float,
    height: float,
    changes: dict[Any, Any] | None = None,
    layout: Literal["constrained"] | None = "constrained",
) -> Iterator[Figure]:
    """An empty figure [inch] to draw on in the common style, with ``changes``."""
    with style(changes):
        yield Figure(figsize=(width, height), layout=layout)


@contextlib.contextmanager
def panelled(
    width: float, height: float, count: int = 1, columns: int = 0, legend: int = 0, grid: bool = True
) -> Iterator[tuple[Figure, list[Axes]]]:
    """A figure [inch] of ``count`` panels, row by row in so many ``columns`` (0: in one row), with or without a
    ``grid``, over one ``legend`` for all of them of so many columns (0: none)."""
    columns = columns or count
    with drawing(width, height, {"axes.grid": grid}) as figure:
        panels = list(figure.subplots(-(-count // columns), columns, squeeze=False).ravel())
        for panel in panels[count:]:
            panel.set_axis_off()
        yield figure, panels[:count]
        if legend:
            legend_below(figure, panels[:count], legend)


@contextlib.contextmanager
def pair(legend: int, title: str = "") -> Iterator[tuple[Figure, list[Axes]]]:
    """Two panels beside each other over a ``legend`` of so many columns, in a fixed frame: the same from picture to
    picture, and at no cost, where finding one takes a fifth of the drawing. Its margins hold labels of six digits."""
    with drawing(WIDE, 3.4, layout=None) as figure:
        frame = {"left": 0.1, "right": 0.985, "wspace": 0.3, "top": 0.94 - 0.07 * len(title.splitlines())}
        panels = list(figure.subplots(1, 2, gridspec_kw=frame))
        figure.suptitle(title)
        for axes in panels:
            few_ticks(axes, 6)
        yield figure, panels
        legend_below(figure, panels, legend)


def few_ticks(axes: Axes, most: int) -> None:
    """Round numbers in at most ``most`` intervals along either axis, the labels at a fixed distance: half of a figure's
    time goes into its ticks, a quarter of that into measuring how far they reach."""
    to_inches = axes.figure.dpi_scale_trans
    for axis, place, away in ((axes.xaxis, (0.5, 0.0), (0.0, -0.24)), (axes.yaxis, (0.0, 0.5), (-0.45, 0.0))):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]))
        axis.set_label_coords(*place, transform=axes.transAxes + ScaledTranslation(*away, to_inches))


def enlarged(axes: Axes, x: Array, y: Array, level: float) -> Axes:
    """An inset over the long free way of a record, with limits around the points ``x, y`` of its contact; under the way
    where that lies, at the ``level`` in shares of the axis, in the upper half."""
    bottom, top = (level + 0.1, 0.98) if level < 0.5 else (0.1, level - 0.06)
    return inset(axes, (0.16, bottom, 0.5, top - bottom), x, y, 0.08, 6)


def inset(axes: Axes, place: Box, x: Array, y: Array, margin: float, letters: float) -> Axes:
    """An inset at a ``place`` with limits around the points ``x, y``, ``margin`` of their extent away, and with small
    ``letters`` at its ticks."""
    within = axes.inset_axes(place)
    within.set(xlim=ends(x, margin), ylim=ends(y, margin))
    within.tick_params(labelsize=letters, pad=1.5, length=2)
    few_ticks(within, 3)
    return within


def zero_lines(axes: Axes) -> None:
    """Both axes through zero."""
    axes.axhline(0, color="0.7", lw=0.6)
    axes.axvline(0, color="0.7", lw=0.6)


def ends(values: Array, margin: float, above: float | None = None) -> tuple[float, float]:
    """Ends of an axis a ``margin`` of their extent beyond ``values``; ``above``: that over the largest, where it is
    another."""
    low, high = float(np.min(values)), float(np.max(values))
    return low - margin * (high - low), high + (margin if above is None else above) * (high - low)


def legend_below(figure: Figure, axes: Iterable[Axes], ncols: int) -> None:
    """One legend for all ``axes`` under them, where it covers nothing; each label once."""
    handles: dict[str, Any] = {}
    for place in axes:
        for handle, label in zip(*place.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    if handles:
        fixed = figure.get_layout_engine() is None
        under: Any = "lower center" if fixed else "outside lower center"
        figure.legend(list(handles.values()), list(handles), loc=under, ncols=ncols)
        if fixed:
            room = 0.57 + 0.16 * -(-len(handles) // ncols)  # labels of the axis, then lines of the legend [inch]
            figure.subplots_adjust(bottom=min(room / figure.get_figheight(), 0.7))


def log_ends(values: Array, least: float = 3.0, margin: float = 1.1) -> tuple[float, float]:
    """Ends of a logarithmic axis around ``values`` > 0, at least a factor of ``least`` apart."""
    low, high = float(np.min(values)), float(np.max(values))
    margin = max(margin, (least * low / high) ** 0.5)
    return low / margin, high * margin


def log_ticks(*axes: Axis) -> None:
    """Plain numbers at 1, 2 and 5 of each decade where a logarithmic axis has few, powers of ten where it has many."""
    for axis in axes:
        low, high = axis.get_view_interval()
        if high / low < 100:
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def save(figure: Figure, paths: Iterable[Path]) -> None:
    """Write a figure to files, each atomically; PNG or SVG by the ending, reproducible to the byte, marked as ours.

    Its layout is computed once, for the resolution of print; ``savefig`` would do so for every file, and draw twice.
    """
    mark, software = f"jkr {__version__}", PngInfo()
    software.add_text("Software", mark)
    with style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)  # drawn as a box
        for text in figure.findobj(Text):
            # Foreign words do nothing: control characters, of which SVG may hold none, as escapes, and what is no
            # formula in TeX's language as it stands.
            words = "\n".join([printable(line) for line in text.get_text().split("\n")])  # map is a module of this room
            text.set_text(words)
            if "$" in words:
                font = text.get_fontproperties().copy()
                font.set_size(text_to_path.FONT_SCALE)  # as SVG asks for it: read once, and remembered
                try:
                    text_to_path.mathtext_parser.parse(words, text_to_path.DPI, font)
                except ValueError:
                    text.set_parse_math(False)
        figure.set_dpi(DPI)
        svg, png = FigureCanvasSVG(figure), FigureCanvasAgg(figure)  # the layout is that of the last, by its letters
        if (engine := figure.get_layout_engine()) is not None:
            engine.execute(figure)
        figure.set_layout_engine("none")
        for path in paths:
            with atomic(path) as temporary:
                if path.suffix == ".png":
                    figure.set_dpi(DPI)  # SVG has 72
                    png.draw()  # type: ignore[no-untyped-call]
                    # No figure is transparent: without that channel a fifth less to encode; level 3 takes two thirds
                    # of the default's time, for a seventh more bytes
                    drawn = png.buffer_rgba()  # type: ignore[no-untyped-call]
                    image = Image.frombuffer("RGBA", png.get_width_height(), drawn).convert("RGB")
                    image.save(temporary, "png", dpi=(DPI, DPI), pnginfo=software, compress_level=3)
                else:
                    svg.print_svg(temporary, metadata={"Creator": mark, "Date": None})  # type: ignore[no-untyped-call]
