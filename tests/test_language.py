"""The field's words: phrases that a reader of the field would read twice stand in no message and on no user's page."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
PHRASES = (
    "the data ask for no other model", "asked for by the data", "cannot be told from", "is what the data leave",
    "left out would change", "body by flags", "its sign as it is", "from the head of the file", "found out]",
    "of the data's size", "Hertz at the deepest row", "at the deepest row would", "between the rows up to",
    "made by another program", "times this body's", "edge advances", "edge rests", "edge recedes",
    "specimens that relax", "zero points", "series file", "tension of the zone", "body that relaxes",
    "moduli that relax", "as told", "(model) is", "pull-off units", "unknown: made", "deepest row", "no turn ",
    "load further", "rows count as one", "follow their neighbours", "model ±", "speak against this model",
    "not excluded by these rows", "geometrically linear theory", "in contact from end to end", "goes on pulling",
    "in SI units stands in", "distance of atoms", "position of the device", "light that the specimen",
    "by chance: ", "most memory to begin", "Of the bootstrap", "takes a guess", "surfaces that stick",
)  # fmt: skip
PAGES = [ROOT / "README.md", *(page for page in (ROOT / "docs").rglob("*.md") if page.parent.name != "project")]


def texts(path: Path) -> Iterator[str]:
    """The strings of a module but its docstrings; an f-string's constant parts."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    docs = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body and isinstance(node.body[0], ast.Expr)
    }  # fmt: skip
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs:
            yield node.value


def test_no_message_and_no_page_has_one_of_the_phrases() -> None:
    pages = [(page, page.read_text(encoding="utf-8")) for page in PAGES]
    assert [(path.name, phrase) for path, said in (*MESSAGES, *pages) for phrase in PHRASES if phrase in said] == []


def test_no_name_in_braces_is_printed_as_it_is() -> None:
    """A message of several parts of which one is no f-string; templates that are filled in later have no other."""
    later = {"case/models.py", "many/maps.py", "fem/figures.py"}  # filled in by str.format, subscripts of symbols
    found = [(f"{path.parent.name}/{path.name}", said) for path, said in MESSAGES if re.search(r"\{[a-z_]+\}", said)]
    assert [name for name, _ in found if name not in later] == []


MESSAGES = [(path, said) for path in (ROOT / "jkrcli").rglob("*.py") for said in texts(path)]
