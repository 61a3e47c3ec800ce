"""Every figure as it would be printed: nothing cut, no label on another, no legend or inset on a curve, the same bytes.

The figures are those that the verbs draw: ``plots.save`` is replaced by a collector.
"""

import itertools
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from fit_data import sphere
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from jkrcli.adhesion.curve import CriticalPoint, transform
from jkrcli.case import store
from jkrcli.measured.archive import Map
from jkrcli.measured.figures import _broken, map_figure
from jkrcli.report import plots
from jkrcli.report import plots as looks
from jkrcli.report.plots.forward import curve_figure, physical_units
from jkrcli.report.result import Files
from jkrcli.resolve.analysis import Analysis, analyse
from studies import paper
from studies.failures import LOOKS
from studies.failures_judge import OUTCOMES

CASES = Path(__file__).parents[2] / "cases"
BODY = """
indenter = {{ shape = "paraboloid", radius = "10 um" }}
specimen.half_space = {{ E = "0.75 MPa", nu = 0.5 }}
loading = {{ radius = "{radius}", points = 40 }}
adhesion.w = "{w}"
"""
SLACK = 1.0  # pixels at 100 dpi: round-off of text extents
SMALLEST = 7.0  # points, of any text in print


@pytest.fixture(name="kept")
def _kept(monkeypatch: pytest.MonkeyPatch) -> Callable[..., list[Figure]]:
    """Run a command and return the figures that it would have saved, each once."""

    def run(command: Callable, *words: object) -> list[Figure]:
        figures: list[Figure] = []
        with monkeypatch.context() as patch:
            patch.setattr(plots, "save", lambda figure, paths: figure in figures or figures.append(figure))
            done = command(*words)
        assert done.code in (0, 1), done.err
        return figures

    return run


@pytest.fixture(name="drawn")
def _drawn(jkr: Callable, kept: Callable[..., list[Figure]]) -> Callable[..., list[Figure]]:
    return partial(kept, jkr)


@pytest.fixture(name="body")
def _body(jkr: Callable) -> str:
    Path("body.toml").write_text(BODY.format(radius="9 um", w="100 mJ/m^2"))
    assert jkr("run", "body.toml", "--method", "layered").code == 0
    return "body.h5"


@plots.style()  # ticks that are made on drawing take their looks from here, as they do in plots.save
def troubles(figure: Figure, smallest: float = SMALLEST) -> list[str]:
    """What a reader would complain about."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    found = [f"{text.get_fontsize()} pt: {text.get_text()}" for text in figure.findobj(Text)
             if text.get_text().strip() and text.get_visible() and text.get_fontsize() < smallest]  # fmt: skip
    for axes in figure.axes:
        if not axes.axison:
            continue
        box = axes.get_tightbbox(renderer)
        assert box is not None
        if not _inside(box, figure.bbox):
            found.append(f"cut: {box} of {figure.bbox}")
        for axis in (axes.xaxis, axes.yaxis):
            found += [f"{axis.axis_name} labels overlap: {words}" for words in _overlapping(axis)]
            found += [f"{axis.label.get_text()} is on {text}" for text in _under_the_label(axis)]
        if any(legend.get_window_extent(renderer).overlaps(_shrunk(box)) for legend in figure.legends):
            found.append(f"the legend covers {axes.get_xlabel()} or what is above")
        inner = axes.get_legend()
        covers: list[Legend | Axes] = [*axes.child_axes, *([inner] if inner else [])]
        found += [f"{type(cover).__name__} covers a curve" for cover in covers
                  if _covered(axes, cover.get_window_extent(renderer))]  # fmt: skip
    return found


def _inside(box: Bbox, whole: Bbox) -> bool:
    return box.x0 >= -SLACK and box.y0 >= -SLACK and box.x1 <= whole.x1 + SLACK and box.y1 <= whole.y1 + SLACK


def _shrunk(box: Bbox) -> Bbox:
    return Bbox.from_extents(box.x0 + SLACK, box.y0 + SLACK, box.x1 - SLACK, box.y1 - SLACK)


def _shown(axis: Axis) -> list[Text]:
    low, high = sorted(axis.get_view_interval())
    labels = [tick.label1 for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return [label for label in labels if label.get_text() and label.get_visible()]


def _under_the_label(axis: Axis) -> list[str]:
    label = axis.label.get_window_extent()
    return [
        text.get_text() for text in _shown(axis) if axis.label.get_text() and text.get_window_extent().overlaps(label)
    ]


def _overlapping(axis: Axis) -> list[str]:
    shown = _shown(axis)
    boxes = [label.get_window_extent() for label in shown]
    return [f"{one.get_text()}, {two.get_text()}" for (one, a), (two, b)
            in itertools.pairwise(zip(shown, boxes, strict=True)) if a.overlaps(_shrunk(b))]  # fmt: skip


def _covered(axes: Axes, box: Bbox) -> bool:
    """Whether a drawn curve, straight reference lines apart, passes through ``box``, where it is not clipped."""
    seen = Bbox.intersection(box, axes.bbox)
    if seen is None:
        return False
    for line in axes.lines:
        points = np.column_stack(line.get_data()).astype(float)
        if len(points) > 2 and line.get_transform() == axes.transData:
            pixels = line.get_transform().transform(points)
            x, y = np.linspace(pixels[:-1], pixels[1:], 20).reshape(-1, 2).T
            if np.any((x > seen.x0) & (x < seen.x1) & (y > seen.y0) & (y < seen.y1)):
                return True
    return False


def analysed(jkr: Callable, case: str) -> Analysis:
    assert jkr("run", CASES / f"{case}.toml", "--method", "layered", "-o", "x.h5").code == 0
    solution = store.read_solution(Path("x.h5"))
    return analyse(solution, solution.record.w[:1])[0]


@pytest.mark.first(2)
@pytest.mark.parametrize(
    ("case", "enlarged"), [("halfspace", True), ("gel", True), ("thin-layer", True), ("coating", False)]
)
def test_tension_is_enlarged_where_it_is_less_than_a_fifth_of_the_loads(jkr, case, enlarged) -> None:
    """The inset lies where no curve passes and holds the pull-off point."""
    result = analysed(jkr, case)
    units = physical_units(result.curve)
    figure = curve_figure(result, units)
    assert troubles(figure) == []
    point = result.pull_off["load"]
    assert isinstance(point, CriticalPoint)
    insets = [inset for axes in figure.axes for inset in axes.child_axes]
    assert len(insets) == (2 if enlarged else 0)
    for inset, (x, y) in zip(insets, (("delta", "P"), ("P", "a")), strict=False):
        for name, (low, high) in ((x, inset.get_xlim()), (y, inset.get_ylim())):
            assert low < getattr(point, name) / getattr(units, name) < high


def test_a_band_is_drawn_where_it_can_be_seen_only(jkr: Callable, body: str) -> None:
    def words(errors: float) -> list[str]:
        curve = transform(result.curve.series, result.curve.slopes, result.w)
        vars(curve)["errors"] = {"P": np.full(40, errors), "delta": np.zeros(40)}
        figure = curve_figure(replace(result, curve=curve), physical_units(curve))
        return [text.get_text() for text in figure.legends[0].get_texts()]

    result = analyse(store.read_solution(Path(body)), [0.1])[0]
    span = float(np.ptp(result.curve.P))
    assert "95 % band of $P$" in words(0.02 * span)
    assert "95 % band of $P$" not in words(0.005 * span)


@pytest.mark.slow
def test_many_records_with_long_names_are_drawn_whole(drawn: Callable[..., list[Figure]]) -> None:
    z = np.concatenate([np.linspace(-3, 1, 60), np.linspace(1, -3, 60)])
    P = 30 * np.maximum(z, 0) ** 1.5
    noise = np.random.default_rng(1)
    rows = [f"sample-{i:03}-measured-on-a-day-in-May,{x},{y}" for i in range(30)
            for x, y in zip(z, P + noise.normal(size=z.size), strict=True)]  # fmt: skip
    Path("many.csv").write_text("\n".join(["curve,Piezo (um),Force (nN)", *rows]))
    (figure,) = drawn("look", "many.csv", "--stiffness", "5 N/m")
    assert troubles(figure) == []
    boxes = [box for axes in figure.axes if axes.axison and (box := axes.get_tightbbox()) is not None]
    assert len(boxes) == 12
    assert not [1 for one, other in itertools.combinations(boxes, 2) if one.overlaps(_shrunk(other))]


def write_measured() -> None:
    rows = sphere(noise=0.01, seed=5)
    a = np.linspace(3.2e-6, 6.8e-6, len(rows))
    table = np.column_stack([np.arange(len(rows)), a * 1e6, rows.delta * 1e9, rows.P * 1e6]).tolist()
    lines = [",".join(map(repr, row)) for row in table]
    Path("timed.csv").write_text("\n".join(["t_s,a_um,delta_nm,P_uN", *lines]))
    Path("probe.csv").write_text("\n".join(["delta_nm,P_uN", *(line.split(",", 2)[2] for line in lines)]))


@pytest.mark.first(1)
@pytest.mark.parametrize(
    "words",
    [
        ("transform", "body.h5", "--dimensionless", "half-space"),
        ("transform", "body.h5", "--w", 0),
        ("transform", "body.h5", "--scale", "a=1 m", "--scale", "P=70 N", "--scale", "delta=3 m"),
        ("transform", "body.h5", "--scale", "a=1 nm", "--scale", "P=1 pN", "--scale", "delta=1 pm"),
        ("transform", "body.h5", "--together", *[word for w in range(20, 35) for word in ("--w", f"{w} mJ/m^2")]),
        ("cycle", "body.h5"),
        ("cycle", "body.h5", "--stiffness", "1 N/m", "--w-retract", "150 mJ/m^2"),
        ("profile", "body.h5", "--load", 0),
        ("profile", "body.h5", "--a", "2 um", "--w", 0),
        ("fit", "body.h5", "probe.csv"),
        ("work", "body.h5", "timed.csv"),
        ("work", "body.h5", "probe.csv"),
        ("compare", "body.h5", "softer.h5", "--plot", "x.png"),
        ("mesh", CASES / "gel.toml"),
        ("study", "pull-off-map", "--q", 0.01, "--q", 100),
        pytest.param(("study", "converge", CASES / "halfspace.toml", "--levels", 2), marks=pytest.mark.slow),
        pytest.param(("fields", "body.h5", "--a", "3 um"), marks=pytest.mark.slow),
    ],
    ids=lambda words: " ".join(map(str, words)).replace(str(CASES), "cases"),
)
def test_figures_of_the_verbs_are_fit_for_print(jkr, drawn, body, words) -> None:
    write_measured()
    Path("softer.toml").write_text(BODY.format(radius="8.8 um", w="100 mJ/m^2"))
    if "softer.h5" in words:
        assert jkr("run", "softer.toml", "--method", "fem", "-o", "softer.h5").code == 0
    figures = drawn(*words)
    assert figures
    for figure in figures:
        assert troubles(figure) == []
        assert figure.get_size_inches()[0] in (looks.WIDE, looks.MIDDLE, looks.NARROW)


def test_a_map_of_failures_knows_every_outcome() -> None:
    assert set(LOOKS) == set(OUTCOMES)


@pytest.mark.first(1)
@pytest.mark.parametrize("begun", [True, False], ids=["program", "library"])
def test_matplotlib_keeps_its_own_words_but_in_the_program(begun: bool) -> None:
    code = (
        f"from jkrcli.base import process\nif {begun}: process.begin()\nimport jkrcli.report.plots\n"
        "from matplotlib import artist, lines\nprint('drawstyle' in lines.Line2D.set.__doc__)\n"
        "print('drawstyle' in artist.kwdoc(lines.Line2D))\n"
        "print('drawstyle' in lines.Line2D.set.__signature__.parameters)\n"
        "print('drawstyle' in artist.ArtistInspector(lines.Line2D).get_setters())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(not begun), "True", str(not begun), "True"]


def test_phases_of_a_history_are_drawn_apart_and_without_gaps() -> None:
    """A first row out of contact once gave its colour to all of the approach."""
    from jkrcli.report.plots.forward import _runs

    phases = np.array(["free", "advance", "advance", "rest", "recede", "recede"])
    held = list(_runs({"phase": phases, "part": np.array([1, 1, 1, 2, 3, 3])}))
    assert held == [("free", slice(0, 2)), ("advance", slice(1, 3)), ("rest", slice(3, 4)), ("recede", slice(4, 6))]


def test_colour_bars_of_a_map_have_whole_numbers() -> None:
    """A contact point of 12.3456 um stood there as hundredths of an nm over an offset."""
    at, noise = np.arange(4) * 1e-6, np.random.default_rng(0)
    values = {
        "E_star": (2e4, 1.0),
        "w": (1e-3, 1e-6),
        "contact_point": (12.3456e-6, 1e-10),
        "adhesion_force": (2.3e-8, 1e-11),
    }
    images = {name: mean + size * noise.normal(size=(4, 4)) for name, (mean, size) in values.items()}
    figure = map_figure(Map(at, at, images))
    FigureCanvasAgg(figure).draw()
    assert [axes.yaxis.get_offset_text().get_text() for axes in figure.axes] == [""] * len(figure.axes)


def test_names_of_written_files_are_those_that_are_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Braces for several alone; a study without pictures names none."""
    assert str(Files(Path("x"), (".csv", ".json"))) == "x{.csv,.json}"
    assert str(Files(Path("x"), (".csv",))) == "x.csv"
    assert paper.main(["--only", "fig10", "--no-plots", "-o", str(tmp_path)]) == 0
    assert "{}" not in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_a_fitted_line_is_not_joined_from_branch_to_branch() -> None:
    """Free, then in contact up to 4, pinned, then the retraction, which begins at 1: gaps where contact begins and
    where the next branch does."""
    a = np.array([0.0, 0.0, 2.0, 3.0, 4.0, 4.0, 1.0, 1.5])
    (line,) = _broken(a, [np.arange(8.0)])
    np.testing.assert_array_equal(line, [0, 1, np.nan, 2, 3, 4, 5, np.nan, 6, 7])


def test_units_are_typeset_and_words_are_not() -> None:
    words = "instrument of 3 uN/um, vacuum, w = 5 uJ/m^2 at 2 um/s"
    assert looks.pretty(words) == "instrument of 3 µN/µm, vacuum, w = 5 µJ/m² at 2 µm/s"
