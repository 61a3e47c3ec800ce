"""The study of slips: that its list still fits the package, and what it says of tests that see a slip or do not."""

import ast
from pathlib import Path

import pytest
from sources import nodes

from jkrcli.base.errors import SolveError
from studies import mutants
from studies.mutants import ROOT, Slip, noticed_by, slips


def test_every_slip_is_one_line_that_stands_once_and_its_tests_exist() -> None:
    assert len({(slip.file, slip.what) for slip in slips()}) == len(slips()) >= 40
    for slip in slips():
        _, text = slip.made(ROOT)
        if slip.file.endswith(".py"):
            ast.parse(text)
        assert slip.old != slip.new
        assert "\n" not in slip.old + slip.new
        for test in slip.tests:
            file, _, name = test.partition("::")
            held = {node.name for node in nodes(ROOT / "tests" / file) if isinstance(node, ast.FunctionDef)}
            assert name.partition("[")[0] in held | {""}, test


@pytest.fixture(name="tree")
def _tree(tmp_path: Path) -> Path:
    """A package of one function, with a test of it and a test of nothing."""
    files = {
        "jkrcli/__init__.py": "",
        "jkrcli/one.py": "def half(x):\n    return x / 2\n",
        "tests/test_one.py": "from jkrcli.one import half\n\n\ndef test_half():\n    assert half(4) == 2\n\n\n"
        "def test_of_nothing():\n    pass\n",
        "pyproject.toml": '[tool.pytest.ini_options]\nmarkers = ["slow: long"]\n',
    }
    for name, text in files.items():
        (tmp_path / "made" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "made" / name).write_text(text)
    return tmp_path / "made"


SEEN = Slip("one.py", "a third", "x / 2", "x / 3", ("test_one.py",))
UNSEEN = Slip("one.py", "twice", "x / 2", "x * 2", ("test_one.py::test_of_nothing",))


@pytest.mark.slow
def test_what_no_test_notices_is_told(study, tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "ROOT", tree)
    monkeypatch.setattr(mutants, "slips", lambda: [SEEN, UNSEEN])
    outcome = study("mutants", "--workers", 1)
    assert (outcome.code, outcome.err) == (1, "")
    assert outcome.out.startswith("2 slips; first the tests")
    assert {"| one.py | a third | test_one.py::test_half |", "| one.py | twice | NOTHING |"} < {
        *outcome.out.splitlines()
    }
    assert outcome.out.endswith("\n1 of 2 noticed\n")
    assert (tree / "jkrcli/one.py").read_text().endswith("x / 2\n")


def test_wrong_words_are_one_line(study) -> None:
    assert study("mutants", "nowhere.py").err == "jkr: error: mutants: no slip is in a file called nowhere.py\n"


def test_a_slip_that_cannot_be_judged_is_named(study, tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SolveError, match=r"^mutants: one\.py, broken: its tests do not run \(exit code 2\)"):
        noticed_by(tree, Slip("one.py", "broken", "x / 2", "x /", ("test_one.py",)))
    monkeypatch.setattr(mutants, "ROOT", tree)
    monkeypatch.setattr(mutants, "slips", lambda: [Slip("one.py", "gone", "x // 2", "x", ("test_one.py",))])
    outcome = study("mutants", "--workers", 1)
    assert (outcome.code, outcome.err) == (
        2,
        "jkr: error: mutants: jkrcli/one.py must hold once, and holds 0 times: x // 2\n",
    )
