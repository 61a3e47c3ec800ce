"""What an answer tells to type must work where it is typed."""

import re
import shlex
import sys
from pathlib import Path

import pytest

from jkrcli.base import errors

ROOT = Path(__file__).parents[2]


def test_a_checkout_installs_from_itself() -> None:
    assert shlex.split(errors.installs("fast")) == [sys.executable, "-m", "pip", "install", "-e", f"{ROOT}[fast]"]
    assert shlex.split(errors.installs(""))[-1] == str(ROOT)


def test_an_installed_package_names_the_packages_of_the_part(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """It may be on no index itself: a line with its name would fetch what others call so, or nothing."""
    monkeypatch.setattr(errors, "__file__", str(tmp_path / "lib" / "base" / "installing.py"))
    pip, (package,) = shlex.split(errors.installs("afm"))[1:-1], shlex.split(errors.installs("afm"))[-1:]
    assert pip == ["-m", "pip", "install"]
    assert re.fullmatch(r"afmformats[<>=.,\d]+", package)
    required = shlex.split(errors.installs(""))[4:]
    assert {"numpy", "gmsh", "click"} <= {re.split(r"[<>=]", name)[0] for name in required}
    assert not {"afmformats", "pytest"} & {re.split(r"[<>=]", name)[0] for name in required}
