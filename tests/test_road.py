"""The road of a run and of a transformation: from file to file as their functions are called first, as a reader meets
them. CONTRIBUTING.md tells it; how often it changes from one file to another has a ceiling."""

import re
import subprocess
import sys
from itertools import groupby
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
# Calls a command and prints the file of each function of the package that is called, at its first call.
FOLLOW = """
import sys
met = {}

def follow(frame, event, argument):
    code = frame.f_code
    if event == "call" and "/jkrcli/" in code.co_filename and code.co_flags & 1 and code.co_qualname[-1] != ">":
        met.setdefault((code.co_filename.rpartition("/jkrcli/")[2], code.co_firstlineno, code.co_qualname))

sys.setprofile(follow)
from jkrcli.cli import call
code = call(sys.argv[1:])
sys.setprofile(None)
print(*(file for file, *_ in met), sep="\\n", file=sys.stderr)
sys.exit(code)
"""
COMMANDS = {
    "run": ("run", str(ROOT / "cases/gel.toml"), "-o", "gel.h5", "--method", "layered"),
    "transform": ("transform", "gel.h5", "--w", "50 mJ/m^2", "--no-plots"),
}
MOST = {"run": 130, "transform": 224}  # changes of file


@pytest.fixture(scope="module")
def roads(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """For each command the files, one entry for each function at its first call."""
    folder = tmp_path_factory.mktemp("road")
    found = {}
    for verb, command in COMMANDS.items():
        done = subprocess.run([sys.executable, "-c", FOLLOW, *command], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        found[verb] = re.findall(r"^\S+\.py$", done.stderr, re.MULTILINE)
    return found


@pytest.mark.slow
def test_a_reader_changes_file_no_more_often_than_was_agreed(roads: dict[str, list[str]]) -> None:
    changes = {verb: len(list(groupby(files))) for verb, files in roads.items()}
    assert all(changes[verb] <= most for verb, most in MOST.items()), changes


@pytest.mark.slow
@pytest.mark.parametrize("verb", COMMANDS)
def test_the_contributors_page_tells_the_road(verb: str, roads: dict[str, list[str]]) -> None:
    """The files that it names come in this order, counted from the verb's own."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    told = re.findall(r"`([\w/]+\.py)`", re.search(rf"^- `jkr {verb}`: (.*?)(?=^- |^$)", text, re.M | re.S)[1])
    road = roads[verb][roads[verb].index(told[0]) :]
    assert len(told) > 8
    assert sorted(told, key=road.index) == told
