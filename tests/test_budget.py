"""The code stays within its budget: lines and tokens of the core, of each wing and of the tests (``budget.toml``)."""

import ast
import io
import tokenize
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from jkrcli.base.wings import PACKAGE, wings

ROOT = PACKAGE.parent
BUDGET = tomllib.loads((Path(__file__).parent / "budget.toml").read_text())
SILENT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER,
    tokenize.ENCODING,
}  # fmt: skip
# Since Python 3.12 the parts of an f-string are tokens: it counts as one
F_STRING = getattr(tokenize, "FSTRING_START", -1), getattr(tokenize, "FSTRING_END", -1)


def docstrings(source: str) -> set[int]:
    """The lines of all docstrings."""
    lines = set[int]()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and node.body:
            first = node.body[0]
            if isinstance(first, ast.Expr) and isinstance(getattr(first.value, "value", None), str):
                lines.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    return lines


def counted(paths: Iterator[Path]) -> dict[str, int]:
    """Lines that hold code and their tokens, without comments and docstrings."""
    tokens, held = 0, set[tuple[Path, int]]()
    for path in paths:
        source = path.read_text(encoding="utf-8")
        silent = docstrings(source)
        code, inside = list[tokenize.TokenInfo](), 0
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            inside -= token.type == F_STRING[1]
            if not inside and token.type not in SILENT and token.type != F_STRING[1] and token.start[0] not in silent:
                code.append(token)
            if token.type not in SILENT and token.start[0] not in silent:
                held.update((path, line) for line in range(token.start[0], token.end[0] + 1))
            inside += token.type == F_STRING[0]
        tokens += len(code)
    return {"lines": len(held), "tokens": tokens}


def parts() -> dict[str, Iterator[Path]]:
    """The files of the core, of each wing and of the tests."""
    names = [wing.name for wing in wings()]
    core = (path for path in PACKAGE.rglob("*.py") if path.relative_to(PACKAGE).parts[0] not in names)
    return {"core": core, **{name: (PACKAGE / name).rglob("*.py") for name in names},
            "tests": (ROOT / "tests").rglob("*.py")}  # fmt: skip


@pytest.mark.parametrize("part", BUDGET)
def test_no_part_is_larger_than_its_budget(part: str) -> None:
    """What is to grow names what it replaces, or what else gets smaller: see CONTRIBUTING."""
    found = counted(parts()[part])
    assert all(size <= BUDGET[part][name] for name, size in found.items()), found


def test_every_part_has_a_budget() -> None:
    assert set(parts()) == set(BUDGET)
