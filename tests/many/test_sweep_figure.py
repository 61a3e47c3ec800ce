"""The picture of a sweep: which results are drawn over which axis, in whose units."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from jkrcli.many.sweep import sweep_figure
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


def test_what_holds_no_numbers_has_no_picture(tmp_path: Path) -> None:
    plan, table = planned(tmp_path, 'key = "specimen.base"\nvalues = ["bonded", "frictionless"]\n')
    assert sweep_figure(plan, table) is None


@pytest.mark.slow
def test_a_sweep_leaves_its_picture_unless_told_otherwise(jkr: Callable) -> None:
    sweep = CASES / "sweeps" / "gel.toml"
    assert jkr("sweep", sweep, "-o", "r", "--no-plots").code == 0
    assert not Path("r/table.png").exists()
    assert "r/table.png, r/table.svg" in jkr("sweep", sweep, "-o", "r").out
    assert Path("r/table.svg").stat().st_size > 1000
