"""Notebooks (.ipynb) as pages of the site, and `make notebooks`, which runs them and keeps what they print and draw.

They are run here cell by cell in one process, as Jupyter would: the value of a last line is shown, figures as pictures.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parents[1] / "notebooks"
PNG = "image/png"


def executed(notebook: dict[str, Any]) -> dict[str, Any]:
    """The notebook with what its code cells print and show when they are run in an empty folder."""
    names: dict[str, Any] = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        cells = [cell | {"outputs": _run(cell, names)} if _is_code(cell) else cell for cell in notebook["cells"]]
    return notebook | {"cells": cells}


def _is_code(cell: dict[str, Any]) -> bool:
    return bool(cell["cell_type"] == "code")


def _run(cell: dict[str, Any], names: dict[str, Any]) -> list[dict[str, Any]]:
    """The outputs of a cell; lines for Jupyter alone, which begin with %, are left out."""
    lines = [line for line in "".join(cell["source"]).splitlines() if not line.startswith("%")]
    tree = ast.parse("\n".join(lines))
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    outputs = []
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(True)})
    if hasattr(value, "savefig"):
        value.savefig(picture := io.BytesIO(), dpi=100, metadata={"Software": None})
        data = {PNG: base64.b64encode(picture.getvalue()).decode()}
        outputs.append({"output_type": "display_data", "data": data, "metadata": {}})
    return outputs


def as_markdown(notebook: dict[str, Any]) -> str:
    """A notebook as a page: its text, its code, what that printed, its pictures."""
    return "\n\n".join(part for cell in notebook["cells"] for part in _parts(cell))


def _parts(cell: dict[str, Any]) -> Iterator[str]:
    text = "".join(cell["source"])
    yield f"```python\n{text}\n```" if _is_code(cell) else text
    for output in cell.get("outputs", ()):
        if "text" in output:
            yield f"```text\n{''.join(output['text']).rstrip()}\n```"
        else:
            yield f"![Picture of the cell above](data:{PNG};base64,{output['data'][PNG]})"


def setup(app: Any) -> dict[str, bool]:
    """Registers the ending .ipynb with Sphinx."""
    from myst_parser.parsers.sphinx_ import MystParser

    class NotebookParser(MystParser):  # type: ignore[misc]
        """Reads a notebook as the page that it stands for."""

        supported = ("ipynb",)

        def parse(self, inputstring: str, document: Any) -> None:
            super().parse(as_markdown(json.loads(inputstring)), document)

    app.add_source_suffix(".ipynb", "ipynb")
    app.add_source_parser(NotebookParser)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def main() -> None:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for path in sorted(FOLDER.glob("*.ipynb")):
        print(path.name)
        held = executed(json.loads(path.read_text(encoding="utf-8")))
        path.write_text(json.dumps(held, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
