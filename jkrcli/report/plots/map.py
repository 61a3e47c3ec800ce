"""The figure of a map: an image per quantity, one cell per pixel, pixels without a value left white."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import ScalarFormatter

from ...base import Array
from ..map import IMAGES, Map
from . import Axes, Figure, panelled
from .looks import LABELS, WIDE, unit_of


def map_figure(scan: Map) -> Figure:
    """Five images over the positions of the curves."""
    length, word = unit_of("length", np.ptp(scan.x), np.ptp(scan.y))
    with panelled(WIDE, 4.0, len(scan.images), columns=3, grid=False) as (figure, panels):
        for i, (panel, (name, image)) in enumerate(zip(panels, scan.images.items(), strict=False)):
            _image(figure, panel, scan, name, image, length)
            panel.set_xlabel(f"$x$ ({word})" if i + 3 >= len(scan.images) else "")
            panel.set_ylabel(f"$y$ ({word})" if i % 3 == 0 else "")
        return figure


def _image(figure: Figure, axes: Axes, scan: Map, name: str, image: Array, length: float) -> None:
    """The ``image`` of one quantity over positions in units of ``length`` [m]."""
    known = image[np.isfinite(image)]
    factor, unit = (1.0, "") if name == "quality" else unit_of(IMAGES[name], known if known.size else 1.0)
    unknown = name == "quality" or not known.size
    ends = (0.0, 1.0) if unknown else np.percentile(known / factor, (2, 98))  # single pixels do not flatten the rest
    x, y = scan.x - scan.x[0], scan.y - scan.y[0]
    pitch = max(np.ptp(at) / (at.size - 1) for at in (x, y) if at.size > 1)
    cells = (_edges(at, float(pitch)) / length for at in (x, y))
    drawn = axes.pcolormesh(*cells, image / factor, shading="flat", cmap="viridis",
                            vmin=ends[0], vmax=ends[1], rasterized=True)  # fmt: skip
    figure.colorbar(drawn, ax=axes, format=ScalarFormatter(useOffset=False))
    label = LABELS.get(name, name.replace("_", " "))
    axes.set_title(f"{label} ({unit})" if unit else label)
    axes.set_aspect("equal")


def _edges(middle: Array, pitch: float) -> Array:
    """The edges of cells around ``middle``; of a single one ``pitch`` wide."""
    if middle.size == 1:
        return np.array([middle[0] - pitch / 2, middle[0] + pitch / 2])
    inner = (middle[1:] + middle[:-1]) / 2
    return np.concatenate([[2 * middle[0] - inner[0]], inner, [2 * middle[-1] - inner[-1]]])
