"""A wing registers what it adds; without its folder the rest works, and what was its own is refused by its name."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import jkrcli
from jkrcli.base.wings import wings

PACKAGE = Path(jkrcli.__file__).parent
CASES = PACKAGE.parent / "cases"
WINGS = tomllib.loads((PACKAGE / "wings.toml").read_text(encoding="utf-8"))


def test_what_is_refused_by_name_is_what_wings_register() -> None:
    assert {wing.name: wing.names for wing in wings()} == WINGS


@pytest.mark.parametrize("wing", WINGS)
def test_a_wing_is_names_and_help_alone(wing: str) -> None:
    code = f"import sys, jkrcli.{wing}.wing\nprint([name for name in sys.modules if name.startswith('numpy')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    assert {path.name for path in (PACKAGE / wing).iterdir()} > {"wing.py"}


@pytest.mark.parametrize("wing", WINGS)
def test_without_a_wing_the_core_gives_the_same(wing: str, tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "jkrcli", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(CASES / "gel.toml", tmp_path)

    def jkr(*words: str) -> subprocess.CompletedProcess[str]:
        program = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from jkrcli.cli import call; "
        command = [sys.executable, "-c", f"{program}sys.exit(call(sys.argv[1:]))", *words]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    def curves() -> list[str]:
        assert jkr("run", "gel.toml", "-o", "gel.h5").returncode == 0
        done = jkr("transform", "gel.h5", "--w", "35 mJ/m^2", "--no-plots", "-o", ".")
        assert done.returncode == 0, done.stderr
        return [path.read_text() for path in sorted(tmp_path.glob("gel-w*.csv"))]

    whole = curves()
    assert whole
    shutil.rmtree(tmp_path / "jkrcli" / wing)
    assert curves() == whole
    told = jkr("--help").stdout
    for verb in WINGS[wing].get("verbs", ()):
        assert f"  {verb} " not in told
        refused = jkr(verb)
        assert (refused.returncode, f'is of the wing "{wing}"' in refused.stderr) == (2, True)
    for option in WINGS[wing].get("options", ()):
        refused = jkr("fit" if option in ("--law", "--relaxation", "--terms") else "cycle", "gel.h5", option, "1")
        assert (refused.returncode, f'is of the wing "{wing}"' in refused.stderr) == (2, True), option
    for name in WINGS[wing]["functions"]:
        program = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import jkrcli; jkrcli.{name}"
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        assert f'AttributeError: {name}: is of the wing "{wing}"' in done.stderr
