"""What is printed says it in the field's words: phrases that stand for a term of the field are found and named."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
# A phrase of our own, and what the field says
PHRASES = {
    "load further": "increase [loading] radius",
    "rows count as one": "residuals are autocorrelated (effective sample size n/...)",
    "follow their neighbours": "residuals are autocorrelated",
    "model ±": "systematic (model) ±",
    "speak against this model": "model rejected, p = ...",
    "by chance: ": "model rejected, p = ...",
    "not excluded by these rows": "the data allow ranges up to ...",
    "geometrically linear theory": "small-strain theory",
    "in contact from end to end": "no straight base line",
    "goes on pulling": "not defined under load control",
    "in SI units stands in": "arbitrary units",
    "distance of atoms": "interatomic spacing",
    "position of the device": "piezo position z, crosshead position, displacement",
    "light that the specimen": "optical interference",
    "most memory to begin": "refuse runs that need more memory",
    "Of the bootstrap": "number of bootstrap resamples",
    "takes a guess": "enter a guess for unknown moduli",
    "surfaces that stick": "no slip",
}


def printed(path: Path) -> Iterator[str]:
    """Texts of a module that are not docstrings, pieces that stand together as one."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
    for node in ast.walk(tree):  # the docstring of a command is its help
        if isinstance(node, ast.FunctionDef) and any("click" in ast.dump(one) for one in node.decorator_list):
            yield ast.get_docstring(node) or ""


def docstrings(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
    return {ast.get_docstring(node, clean=False) or "" for node in ast.walk(tree) if isinstance(node, kinds)}


def texts() -> dict[Path, str]:
    """What each module prints and each page says, in small letters."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    found = {path: " ".join(path.read_text(encoding="utf-8").split()) for path in pages}
    for path in (ROOT / "jkrcli").rglob("*.py"):
        own = docstrings(path)
        found[path] = "\n".join(text for text in printed(path) if text not in own)
    return {path: text.lower() for path, text in found.items()}


def test_what_is_printed_is_said_in_the_words_of_the_field() -> None:
    said = texts()
    found = [
        f"{path.relative_to(ROOT)}: {phrase}, say {better}"
        for phrase, better in PHRASES.items()
        for path, text in said.items()
        if phrase.lower() in text
    ]
    assert found == []
