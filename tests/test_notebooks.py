"""The notebooks of docs run from their first cell to their last and print what is kept in them; the site shows them."""

import base64
import json
from pathlib import Path
from typing import Any

import pytest

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
