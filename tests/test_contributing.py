"""CONTRIBUTING.md describes the house as it stands: its rooms, its doors, and one place for each thing looked for."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest
from sources import nodes
from test_architecture import PACKAGE, ROOMS

TEXT = (PACKAGE.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    lines = TEXT.split(f"\n## {heading}\n", 1)[1].split("\n## ")[0].splitlines()
    table = [line for line in lines if line.startswith("|")]
    return [[cell.strip().strip("`") for cell in line.strip("|").split("|")] for line in table[2:]]


WANTED = {name: (file, definition) for name, file, definition in rows("Where is ...?")}


@cache
def definitions(path: Path) -> list[tuple[str, str]]:
    return [
        (node.name, (ast.get_docstring(node) or "").partition("\n")[0])
        for node in nodes(path)
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
    ]


def found(usual: str) -> list[tuple[str, str]]:
    """Where a name or the first line of a docstring holds a usual name; verbs, whose docstrings are help, apart."""
    pattern = re.compile(rf"\b{re.escape(usual)}\b", re.IGNORECASE)
    return [
        (str(path.relative_to(PACKAGE)), name)
        for path in sorted(PACKAGE.rglob("*.py"))
        if path.relative_to(PACKAGE).parts[0] != "cli"
        for name, line in definitions(path)
        if pattern.search(line) or pattern.search(name.strip("_").replace("_", " "))
    ]


@pytest.mark.parametrize("usual", WANTED)
def test_what_is_looked_for_has_one_definition_where_the_table_says(usual: str) -> None:
    assert found(usual) == [WANTED[usual]]


def test_all_rooms_are_told_in_their_order() -> None:
    assert tuple(row[0] for row in rows("Layout")) == ROOMS


def test_every_path_and_target_named_exists() -> None:
    root = PACKAGE.parent
    named = set(re.findall(r"`([\w./*-]+/[\w./*-]*|[\w-]+\.py)`", TEXT))
    missing = [path for path in named if not any(next(base.glob(path.rstrip("/")), None) for base in (root, PACKAGE))]
    assert missing == []
    targets = set(re.findall(r"^([a-z-]+):", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    assert set(re.findall(r"\bmake ([a-z-]+)", TEXT)) <= targets
