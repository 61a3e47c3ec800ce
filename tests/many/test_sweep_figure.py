"""The picture of a sweep: which results are drawn over which axis, in whose units."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from jkrcli.base.errors import InputError
from jkrcli.many import sweep as running
from jkrcli.many.sweep import alone, sweep_figure
from jkrcli.many.sweep_plan import Plan, load_plan

CASES = Path(__file__).parents[2] / "cases"
THICKNESS = 'key = "specimen.layers[0].thickness"\nvalues = [3e-4, 5e-4, 8e-4]\n'
NU = 'key = "specimen.layers[0].nu"\nvalues = [0.3, 0.4]\n'


def planned(tmp_path: Path, *axes: str) -> tuple[Plan, dict[str, list]]:
    """A sweep with one w, and a table as if each force were the number of its case in mN."""
    text = "".join(f"[[axes]]\n{axis}" for axis in (*axes, 'key = "adhesion.w"\nvalues = [0.04]\n'))
    (tmp_path / "s.toml").write_text(f'base = "{CASES / "gel.toml"}"\n{text}[outputs]\nquantities = ["pull_off"]\n')
    plan = load_plan(tmp_path / "s.toml")
    numbers = range(plan.count)
    columns: dict[str, list] = {"case": list(numbers), "status": ["ok"] * plan.count}
    keys = [tuple(plan.values(number).values()) for number in numbers]
    columns |= dict(zip(plan.key_columns, map(list, zip(*keys, strict=True)), strict=True))
    columns |= {name: [1e-3 * number for number in numbers] for name in plan.recipe.wanted.columns}
    return plan, columns


def test_one_axis_makes_one_line_in_people_s_units(tmp_path: Path) -> None:
    figure = sweep_figure(*planned(tmp_path, THICKNESS))
    left, right = figure.axes
    (line,) = (held for held in left.lines if len(held.get_xdata()) == 3)
    np.testing.assert_allclose(line.get_xdata(), [300, 500, 800])
    np.testing.assert_allclose(line.get_ydata(), [0, 1, 2])
    assert left.get_xlabel() == "thickness of layer 1 (µm)"
    assert (left.get_ylabel(), right.get_ylabel()) == ("load $P$ at pull-off (mN)",) * 2
    assert (left.get_title(), right.get_title()) == ("(a) load control", "(b) displacement control")


def test_two_axes_make_a_line_for_each_value_of_the_shorter(tmp_path: Path) -> None:
    plan, table = planned(tmp_path, NU, THICKNESS)
    table["pull_off.load.P_N"][4] = None  # a case that failed leaves a gap
    figure = sweep_figure(plan, table)
    named = {str(line.get_label()): line for line in figure.axes[0].lines}
    np.testing.assert_allclose(named["nu = 0.3"].get_ydata(), [0, 1, 2])
    np.testing.assert_allclose(named["nu = 0.4"].get_ydata(), [3, np.nan, 5])


def test_over_a_ratio_of_lengths_the_force_is_in_pi_w_R(tmp_path: Path) -> None:
    wide = 'key = "specimen.layers[0].thickness"\nfrom = 1e-4\nto = 1e-2\ncount = 5\nspacing = "log"\n'
    axes = "".join(f"[[axes]]\n{axis}" for axis in (wide, 'key = "adhesion.w"\nvalues = [0.04]\n'))
    wanted = '[outputs]\nquantities = ["pull_off.load"]\nover = "ratios.{}"\n'
    for name, words in (("h_over_R", "$h/R$"), ("a_over_h_at_pull_off", "$a/h$ at pull-off")):
        (tmp_path / "s.toml").write_text(f'base = "{CASES / "gel.toml"}"\n{axes}{wanted.format(name)}')
        plan = load_plan(tmp_path / "s.toml")
        rows = [alone(plan, number).summary() for number in range(plan.count)]
        columns = {column: [row[column] for row in rows] for column in rows[0]}
        (axes_drawn,) = sweep_figure(plan, columns).axes
        (line,) = (held for held in axes_drawn.lines if len(held.get_xdata()) == 5)
        h, (R, w) = np.array(columns["specimen.layers[0].thickness_m"]), (6e-3, 0.04)
        a = np.array(columns["pull_off.load.a_m"])
        order = np.argsort(line.get_xdata())
        x, expected = np.array(line.get_xdata()), h / R if name == "h_over_R" else a / h
        np.testing.assert_allclose(x, np.sort(expected), rtol=1e-12)
        assert axes_drawn.get_xlabel() == words
        assert axes_drawn.get_ylabel() == r"pull-off force / $\pi w R$"
        forces = -np.array(columns["pull_off.load.P_N"]) / (np.pi * w * R)
        np.testing.assert_allclose(np.array(line.get_ydata())[order], forces[np.argsort(expected)], rtol=1e-12)
        if name == "h_over_R":
            assert axes_drawn.get_xscale() == "log"
            format_tick = axes_drawn.xaxis.get_major_formatter()
            shown = [format_tick(tick) for tick in axes_drawn.xaxis.get_majorticklocs() if 0.02 <= tick <= 2]
            assert shown == ["0.02", "0.05", "0.1", "0.2", "0.5", "1", "2"]


def test_over_what_is_no_quantity_is_refused(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(f'base = "{CASES / "gel.toml"}"\n[[axes]]\n{NU}[outputs]\nover = "h/R"\n')
    with pytest.raises(InputError, match=r'outputs\.over: must be one quantity, .*got "h/R"'):
        load_plan(tmp_path / "s.toml")


FLAT = 'indenter = { shape = "flat", radius = 1e-3 }\n'
CONE = 'indenter = { shape = "cone", half_angle = "70 deg" }\n'
LAYER = "specimen = { layers = [{ thickness = 1e-4, E = 1e6, nu = 0.4 }] }\n"
HALF = "specimen = { half_space = { E = 1e6, nu = 0.4 } }\n"
W = '[[axes]]\nkey = "adhesion.w"\nvalues = [0.02, 0.04]\n'


@pytest.mark.parametrize(
    ("bodies", "over", "why"),
    [
        (FLAT + LAYER, "ratios.a_over_h_at_pull_off", 'the shape "flat" has no tip radius'),
        (CONE + LAYER, "pull_off.load.over_pi_w_R", 'the shape "cone" has no tip radius'),
        ('indenter = { shape = "sphere", radius = 1e-3 }\n' + HALF, "ratios.h_over_R", "there is no layer"),
    ],
)
def test_over_what_no_case_has_is_refused(tmp_path: Path, bodies: str, over: str, why: str) -> None:
    text = f'[base]\nloading = {{ radius = 5e-4 }}\n{bodies}{W}[outputs]\nover = "{over}"\n'
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(InputError, match=f"s.toml: outputs.over: {over} is no number of these cases: {why}"):
        load_plan(tmp_path / "s.toml")


def test_over_what_the_cases_have_not_after_all_there_is_no_picture(tmp_path: Path) -> None:
    plan, table = planned(tmp_path, NU)
    table["ratios.h_over_R"] = [None, None]
    assert sweep_figure(replace(plan, over="ratios.h_over_R"), table) is None


def test_a_table_is_there_before_its_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jkr: Callable) -> None:
    def fails(*_: object) -> None:
        raise InputError("not drawn")

    monkeypatch.setattr(running, "sweep_figure", fails)
    wanted = '[outputs]\nquantities = ["pull_off.load"]\n'
    (tmp_path / "s.toml").write_text(f'base = "{CASES / "halfspace.toml"}"\n{W}{wanted}')
    assert jkr("sweep", tmp_path / "s.toml", "-o", "r").code == 2
    assert len(Path("r/table.csv").read_text().splitlines()) == 3


def test_what_holds_no_numbers_has_no_picture(tmp_path: Path) -> None:
    plan, table = planned(tmp_path, 'key = "specimen.base"\nvalues = ["bonded", "frictionless"]\n')
    assert sweep_figure(plan, table) is None
