"""The notebooks of docs run from their first cell to their last and print what is kept in them; the site shows them."""

import ast
import base64
import json
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import jkrcli
from site_parts.notebooks import FOLDER, PNG, as_markdown, executed

NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def read(path: Path) -> dict[str, Any]:
    return dict(json.loads(path.read_text(encoding="utf-8")))


def printed(notebook: dict[str, Any]) -> list[str]:
    outputs = [output for cell in notebook["cells"] for output in cell.get("outputs", ())]
    return [line.rstrip("\n") for output in outputs for line in output.get("text", ())]


def pictures(notebook: dict[str, Any]) -> list[bytes]:
    outputs = [output for cell in notebook["cells"] for output in cell.get("outputs", ())]
    return [base64.b64decode(output["data"][PNG]) for output in outputs if "data" in output]


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_prints_what_is_kept_in_it(path: Path) -> None:
    held = read(path)
    again = executed(held)
    assert printed(again) == printed(held)
    assert len(pictures(again)) == len(pictures(held))


def names_used(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Modules of jkrcli with the names that a script takes from them."""
    for node in ast.walk(tree):
        match node:
            case ast.ImportFrom(module=str(module)) if module.split(".")[0] == jkrcli.__name__:
                yield from ((module, alias.name) for alias in node.names)
            case ast.Attribute(value=ast.Name(id="jkr"), attr=name):
                yield jkrcli.__name__, name


def test_the_names_that_notebooks_and_examples_use_exist() -> None:
    """A picture's module had moved below a notebook, which only a slow test runs."""
    scripts = [path.read_text(encoding="utf-8") for path in (FOLDER.parent / "examples").rglob("*.py")]
    cells = (cell for path in NOTEBOOKS for cell in read(path)["cells"] if cell["cell_type"] == "code")
    scripts += ["".join(line for line in cell["source"] if not line.startswith("%")) for cell in cells]
    used = {name for script in scripts for name in names_used(ast.parse(script))}
    assert len(used) > 10
    assert [name for name in used if not hasattr(import_module(name[0]), name[1])] == []


def test_there_are_three_with_what_they_print_and_draw() -> None:
    assert len(NOTEBOOKS) == 3
    listed = (FOLDER / "index.md").read_text(encoding="utf-8")
    for path in NOTEBOOKS:
        notebook = read(path)
        assert (notebook["nbformat"], path.name in listed) == (4, True)
        assert printed(notebook)
        assert all(picture.startswith(b"\x89PNG") and len(picture) < 60_000 for picture in pictures(notebook))
        assert pictures(notebook)
        assert path.stat().st_size < 120_000


def test_a_page_holds_text_code_output_and_picture() -> None:
    cells = [
        {"cell_type": "markdown", "source": ["# Sum\n", "of two"]},
        {"cell_type": "code", "source": ["%matplotlib inline\n", "print(1 + 1)"]},
        {"cell_type": "code", "source": ["from matplotlib.figure import Figure\n", "Figure(figsize=(1, 1))"]},
    ]
    page = as_markdown(executed({"cells": cells}))
    assert page.startswith("# Sum\nof two\n\n```python\n%matplotlib inline\nprint(1 + 1)\n```\n\n```text\n2\n```\n\n")
    assert "](data:image/png;base64,iVBOR" in page
