"""A wing registers what it adds; without its folder the rest works, and what was its own is refused by its name."""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import jkrcli
from jkrcli.base.wings import offered, wings

PACKAGE = Path(jkrcli.__file__).parent
CASES = PACKAGE.parent / "cases"
# In a copy: what it lacks is not looked for in the editable installation either
OWN = (
    "import sys; sys.meta_path[:] = [f for f in sys.meta_path if 'editable' not in f.__module__]; "
    "sys.path.insert(0, {!r})"
)
WINGS = tomllib.loads((PACKAGE / "wings.toml").read_text(encoding="utf-8"))


def test_what_is_refused_by_name_is_what_wings_register() -> None:
    assert {wing.name: wing.names for wing in wings()} == WINGS


def test_what_is_asked_for_is_offered_and_there() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py"))
    asked = set(re.findall(r'offered\(\s*["\']([^"\']+)["\']', text))
    offers = {name: place for wing in wings() for name, place in wing.offers.items()}
    assert asked == set(offers)
    assert all(offered(name) is not None for name in offers)


@pytest.mark.parametrize("wing", WINGS)
def test_a_wing_is_names_and_help_alone(wing: str) -> None:
    code = (
        f"import sys, jkrcli.{wing}.wing\nprint({{name.split('.')[0] for name in sys.modules}} & {{'numpy', 'click'}})"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
    assert {path.name for path in (PACKAGE / wing).iterdir()} > {"wing.py"}


@pytest.mark.slow
@pytest.mark.parametrize("wing", WINGS)
def test_without_a_wing_the_core_gives_the_same(wing: str, tmp_path: Path) -> None:
    shutil.copytree(PACKAGE, tmp_path / "jkrcli", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(CASES / "gel.toml", tmp_path)

    def jkr(*words: str) -> subprocess.CompletedProcess[str]:
        program = f"{OWN.format(str(tmp_path))}; from jkrcli.cli import call; sys.exit(call(sys.argv[1:]))"
        command = [sys.executable, "-c", program, *words]
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
    needed = f'needs the wing "{wing}", which this installation lacks'
    for verb in WINGS[wing].get("verbs", ()):
        assert f"  {verb} " not in told
        refused = jkr(verb)
        assert (refused.returncode, needed in refused.stderr) == (2, True)
    for named in WINGS[wing].get("options", ()):
        verb, option = named.split()
        refused = jkr(verb, "gel.h5", option, "1")
        assert (refused.returncode, f"{verb}: {option} {needed}" in refused.stderr) == (2, True), option
        assert needed not in jkr("check", "gel.toml", option, "1").stderr  # which never had it
    for name in WINGS[wing].get("methods", ()):
        refused = jkr("run", "gel.toml", "--method", name.removeprefix("method "))
        assert (refused.returncode, needed in refused.stderr) == (2, True)
    for name in WINGS[wing].get("functions", ()):
        program = f"{OWN.format(str(tmp_path))}; import jkrcli; jkrcli.{name}"
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        assert f"AttributeError: {name} {needed}" in done.stderr
    for words in (("pull-off", "gel.h5", "--json"), ("cycle", "gel.h5", "--no-plots", "-o", ".")):
        assert jkr(*words).returncode == 0
