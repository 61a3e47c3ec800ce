"""What cases of a sweep share: a solve at unit modulus, kept solves, rows that depend on their case alone."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from sweep_files import SHARED, TWO_LAYERS, rows

from jkrcli.base.errors import JkrError
from jkrcli.case import store
from jkrcli.many.sweep_plan import at_unit_modulus

pytestmark = pytest.mark.usefixtures("no_pictures")


@pytest.mark.slow
def test_cases_that_differ_in_w_or_one_modulus_factor_share_a_solve(jkr, tmp_path: Path, solves: list) -> None:
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    outcome = jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    assert (outcome.code, len(solves)) == (0, 2)
    table = rows(tmp_path / "r" / "table.csv")
    assert len(table) == 18
    for row in table[3:9:4]:  # against each case solved alone, by the ordinary verbs
        (tmp_path / "one.toml").write_text(jkr("sweep", "s.toml", "--show-case", row["case"]).out)
        assert jkr("run", "one.toml").code == 0
        alone = jkr("transform", "one.h5", "--no-plots", "--json").told["results"][0]
        told = alone["pull_off"]["load"]
        for quantity, unit in (("P", "N"), ("delta", "m")):  # a sweep interpolates to the points, and says its error
            off = abs(float(row[f"pull_off.load.{quantity}_{unit}"]) - told[f"{quantity}_{unit}"])
            stated = float(row[f"pull_off_errors.load.{quantity}_err_{unit}"])
            assert off <= stated < 1e-3 * abs(told[f"{quantity}_{unit}"])
        np.testing.assert_allclose(float(row["validity.tabor"]), alone["tabor"], rtol=1e-12)


@pytest.mark.slow
def test_a_row_depends_on_its_case_alone(jkr, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    first, second, third = SHARED.split("[[axes]]")[1:]
    (tmp_path / "t.toml").write_text(TWO_LAYERS + "".join(f"[[axes]]{axis}" for axis in (third, second, first)))
    for name, workers in (("s", 2), ("t", 1)):
        assert jkr("sweep", f"{name}.toml", "-o", name, "--workers", workers).code == 0
    table, other = (rows(tmp_path / name / "table.csv") for name in "st")
    shuffled = sorted(tuple(sorted((k, v) for k, v in row.items() if k != "case")) for row in other)
    assert sorted(tuple(sorted((k, v) for k, v in row.items() if k != "case")) for row in table) == shuffled
    alone = jkr("sweep", "s.toml", "--only", "7", "--json").told
    assert {k: "" if v is None else str(v) for k, v in alone.items()} == table[7]


def test_a_solve_that_cannot_be_kept_is_no_failed_case(jkr, tmp_path: Path, tuned, monkeypatch) -> None:
    """A full disk is told by the journal and the table, not by cases that count as done from then on."""

    def full(path: Path, *_: object) -> None:
        raise JkrError(f"{path}: cannot be written (No space left on device)")

    tuned("jkrcli.many.sweep_plan.SHARING_WORTH_KEEPING", -1.0)
    monkeypatch.setattr("jkrcli.many.sweep_plan.write_solution", full)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED.partition("[[axes]]\nzip")[0])
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert [row["status"] for row in rows(tmp_path / "r" / "table.csv")] == ["ok"] * 3


def test_unit_modulus_is_the_same_for_every_factor() -> None:
    """1/3 of 3 and 0.7 of 1.4: quotients are rounded alike, and the factor is the surface's E."""
    from jkrcli.bodies.indenters import Sphere
    from jkrcli.bodies.problem import Elastic, HalfSpace, Layer, Loading, Problem, Specimen

    def body(factor: float) -> Problem:
        layers = (Layer(Elastic(1.1 * factor, 0.3), 1e-4),)
        base = HalfSpace(Elastic(0.7 * factor, 0.2))
        return Problem(Sphere(1e-3, Elastic(13 * factor, 0.3)), Specimen(layers, base), Loading("load", 1e-9 * factor))

    bodies = [at_unit_modulus(body(factor)) for factor in (1.0, 3.0, 1 / 3, 1e9, 0.7e-3)]
    assert len({problem.key for problem, _ in bodies}) == 1
    assert [factor for _, factor in bodies] == [1.1 * f for f in (1.0, 3.0, 1 / 3, 1e9, 0.7e-3)]


@pytest.mark.slow
def test_expensive_solves_are_kept(jkr, tmp_path: Path, solves: list, tuned: Callable) -> None:
    """Other quantities of the same bodies: new rows, no new solve; a damaged file is solved again, and both whose files
    have exchanged their names."""
    tuned("jkrcli.many.sweep_plan.SHARING_WORTH_KEEPING", -1.0)
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED)
    jkr("sweep", "s.toml", "-o", "r", "--workers", "1")
    before = rows(tmp_path / "r" / "table.csv")
    kept = sorted((tmp_path / "r" / "solves").iterdir())
    assert [store.read_solution(path).method for path in kept] == ["layered", "layered"]
    (tmp_path / "s.toml").write_text(TWO_LAYERS + SHARED + '[outputs]\nquantities = ["pull_off"]\n')
    kept[0].write_bytes(kept[0].read_bytes()[:-100])
    solves.clear()
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert len(solves) == 1
    assert store.read_solution(kept[0]).method == "layered"
    after = rows(tmp_path / "r" / "table.csv")
    for name in after[0]:
        assert [row[name] for row in after] == [row[name] for row in before]
    (tmp_path / "r" / "journal.jsonl").unlink()
    contents = [path.read_bytes() for path in kept]
    for path, content in zip(kept, contents[::-1], strict=True):
        path.write_bytes(content)
    solves.clear()
    assert jkr("sweep", "s.toml", "-o", "r", "--workers", "1").code == 0
    assert (len(solves), rows(tmp_path / "r" / "table.csv")) == (2, after)
