"""Every number that decides something says where it comes from or what it is.

Algorithms keep their numbers as constants of their module. The comment of each, beside or right above it, says
``theory:`` and the reason, ``tuned on`` what, by which target of make, or ``choice:``; in rooms that compute nothing
any comment does.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SOURCES = sorted([*(ROOT / "jkrcli").rglob("*.py"), *(ROOT / "docs" / "studies").glob("*.py")])
COMPUTES = ("adhesion", "bodies", "formulas", "measured", "methods", "resolve", "series", "viscoelastic")
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
SAYS = re.compile(r"(theory|choice): \S|tuned on .+`make (?P<target>[a-z-]+)`", re.DOTALL)
LEAST_SAID = 4  # characters of a comment that says something


def constants(tree: ast.Module) -> Iterator[tuple[str, ast.expr]]:
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


def numbers(text: str) -> Iterator[tuple[list[str], str]]:
    lines, tokens = text.splitlines(), tokenize.generate_tokens(io.StringIO(text).readline)
    said = {token.start[0]: token.string.strip("# ") for token in tokens if token.type == tokenize.COMMENT}
    for node in ast.parse(text).body:
        names = [name for name, value in constants(ast.Module([node], [])) if is_number(value)]
        if names:
            first = node.lineno
            while first > 1 and lines[first - 2].lstrip().startswith("#"):
                first -= 1
            yield names, " ".join(said.get(line, "") for line in range(first, (node.end_lineno or first) + 1)).strip()


def unexplained(text: str) -> list[str]:
    """Numbers whose comment does not say where they come from."""
    found = []
    for names, words in numbers(text):
        match = SAYS.search(words)
        if match is None or (match["target"] is not None and match["target"] not in TARGETS):
            found += names
    return found


def silent(text: str) -> list[str]:
    """Numbers whose comment says nothing."""
    return [name for names, words in numbers(text) if len(words) < LEAST_SAID for name in names]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_number_says_where_it_comes_from(path: Path) -> None:
    room = path.relative_to(ROOT).parts[1]
    assert (unexplained if room in COMPUTES else silent)(path.read_text(encoding="utf-8")) == []


def test_the_check_sees_a_number_that_says_nothing() -> None:
    assert silent("A = 1\n\nB, C = 2, 3  #\n# rows of a table\nD = 4\nE = 5  # metres\n") == ["A", "B", "C"]
    counted = [name for name, value in constants(ast.parse("A, B = 1, -2.5\nC = 'x'\nD = (1, 2)")) if is_number(value)]
    assert counted == ["A", "B", "D"]


def test_the_check_sees_what_does_not_say_where_it_comes_from() -> None:
    told = ("# theory: Eq. 22", "# tuned on the bodies of make chart, by `make chart`", "# choice: digits shown")
    for comment in (*told, "# what it is", "# tuned on something, by `make nothing`", "#"):
        for text in (f"SHARE = 0.1  {comment}\n", f"{comment}\nSHARE = 1e-3\n"):
            assert unexplained(text) == ([] if comment in told else ["SHARE"])
