"""`make benchmarks`: both trees are timed as they are after their first run."""

from pathlib import Path

import pytest

from docs.benchmarks import measure


def test_both_trees_are_compiled_before_they_are_timed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Where nothing that is imported is kept (PYTHONDONTWRITEBYTECODE) a checkout had no byte code: 0.3 s."""
    (tmp_path / "jkrcli").mkdir()
    (tmp_path / "jkrcli" / "one.py").write_text("a = 1\n")
    compiled = []
    monkeypatch.setattr(measure, "COMMANDS", {})
    monkeypatch.setattr(measure, "timed", lambda *_: compiled.extend((tmp_path / "jkrcli").rglob("one.*.pyc")))
    measure.measure(1, tmp_path)
    assert len(compiled) == 1
