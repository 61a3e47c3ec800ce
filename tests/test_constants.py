"""Every number that decides something says where it comes from or what it is.

A set of tunings is a frozen dataclass of numbers of which its module makes one constant, ``TUNING = Tuning()``; the
comment of each field says ``theory:`` and the reason, ``tuned on`` what, by which target of make, or ``choice:``.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from sources import tree

ROOT = Path(__file__).parent.parent
SOURCES = sorted([*(ROOT / "jkrcli").rglob("*.py"), *(ROOT / "docs" / "studies").glob("*.py")])
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
SAYS = re.compile(r"(theory|choice): \S|tuned on .+`make (?P<target>[a-z-]+)`", re.DOTALL)
LEAST_SAID = 4  # characters of a comment that says something


def constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
    """Names in capitals that a module sets, each with what it is set to."""
    for node in tree.body:
        if isinstance(node, ast.AnnAssign | ast.Assign) and node.value is not None:
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                pairs = [(target, node.value)]
                if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                    pairs = list(zip(target.elts, node.value.elts, strict=True))
                for name, value in pairs:
                    if isinstance(name, ast.Name) and name.id.lstrip("_").isupper():
                        yield name.id, value


def is_number(value: ast.expr) -> bool:
    """Whether an expression is a number, arithmetic of numbers, or a tuple of them."""
    match value:
        case ast.Constant():
            return isinstance(value.value, int | float) and not isinstance(value.value, bool)
        case ast.UnaryOp():
            return is_number(value.operand)
        case ast.BinOp():
            return is_number(value.left) and is_number(value.right)
        case ast.Tuple():
            return bool(value.elts) and all(map(is_number, value.elts))
    return False


def tunings(tree: ast.Module) -> Iterator[ast.ClassDef]:
    """Frozen dataclasses of numbers of which the module makes a constant without arguments."""
    made = {value.func.id for _, value in constants(tree)
            if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and not value.args}  # fmt: skip
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name in made:
            values = [field.value for field in fields(node)]
            if values and all(value is not None and is_number(value) for value in values):
                yield node


def fields(node: ast.ClassDef) -> list[ast.AnnAssign]:
    return [item for item in node.body if isinstance(item, ast.AnnAssign)]


def comments(text: str) -> dict[int, str]:
    """The comment of each line that has one."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return {token.start[0]: token.string for token in tokens if token.type == tokenize.COMMENT}


def unexplained(source: Path | str) -> list[str]:
    """Fields of tunings, in a file or a text, whose comment, beside or right above them, does not say where the number
    comes from."""
    text = source if isinstance(source, str) else source.read_text(encoding="utf-8")
    found: list[str] = []
    held = list(tunings(ast.parse(text) if isinstance(source, str) else tree(source)))
    said = comments(text) if held else {}
    for node in held:
        for field in fields(node):
            assert isinstance(field.target, ast.Name)
            first = field.lineno
            while text.splitlines()[first - 2].lstrip().startswith("#"):
                first -= 1
            words = " ".join(said.get(line, "") for line in range(first, field.end_lineno + 1))
            match = SAYS.search(words)
            if match is None or (match["target"] is not None and match["target"] not in TARGETS):
                found.append(f"{node.name}.{field.target.id}")
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_tuning_says_where_it_comes_from(path: Path) -> None:
    assert unexplained(path) == []


def silent(text: str) -> list[str]:
    """Numbers of a module, outside its sets of tunings, whose comment, beside or right above them, says nothing."""
    lines, said, found = text.splitlines(), comments(text), []
    for node in ast.parse(text).body:
        names = [name for name, value in constants(ast.Module([node], [])) if is_number(value)]
        if names:
            first = node.lineno
            while first > 1 and lines[first - 2].lstrip().startswith("#"):
                first -= 1
            words = [said.get(line, "").strip("# ") for line in range(first, (node.end_lineno or first) + 1)]
            if max(map(len, words)) < LEAST_SAID:
                found += names
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_numbers_that_stand_alone_say_what_they_are(path: Path) -> None:
    assert silent(path.read_text(encoding="utf-8")) == []


def test_the_check_sees_a_number_that_says_nothing() -> None:
    assert silent("A = 1\n\nB, C = 2, 3  #\n# rows of a table\nD = 4\nE = 5  # metres\n") == ["A", "B", "C"]


@pytest.mark.parametrize(
    ("comment", "found"),
    [
        ("# theory: Eq. 22", []),
        ("# tuned on the bodies of make chart, by `make chart`", []),
        ("# choice: digits shown", []),
        ("# what the field is", ["Tuning.share"]),
        ("# tuned on something, by `make nothing`", ["Tuning.share"]),
        ("", ["Tuning.share"]),
    ],
)
def test_the_check_sees_what_says_nothing(comment: str, found: list[str]) -> None:
    made = f"@dataclass(frozen=True)\nclass Tuning:\n    share: float = 0.1  {comment}\n\n\nTUNING = Tuning()\n"
    assert unexplained(made) == found
    above = (
        f"@dataclass(frozen=True)\nclass Tuning:\n    {comment or '#'}\n    share: float = 1e-3\n\nTUNING = Tuning()\n"
    )
    assert unexplained(above) == found
    counted = [name for name, value in constants(ast.parse("A, B = 1, -2.5\nC = 'x'\nD = (1, 2)")) if is_number(value)]
    assert counted == ["A", "B", "D"]
