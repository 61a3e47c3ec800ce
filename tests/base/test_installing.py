"""What an answer tells to type must work where it is typed."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

import pytest

from jkrcli.base import installing

ROOT = Path(__file__).parents[2]


def test_a_checkout_installs_from_itself() -> None:
    assert shlex.split(installing.installs("fast")) == [sys.executable, "-m", "pip", "install", "-e", f"{ROOT}[fast]"]
    assert shlex.split(installing.installs(""))[-1] == str(ROOT)


def test_an_installed_package_comes_from_the_index(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(installing, "__file__", str(tmp_path / "lib" / "base" / "installing.py"))
    assert shlex.split(installing.installs("fast"))[1:] == ["-m", "pip", "install", "jkrcli[fast]"]
