"""`make gallery`: runs the commands of the gallery's page in an empty folder and takes over the pictures it shows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from . import schematics

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def main() -> None:
    page = (HERE / "index.md").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for given in ("cases", "docs", "tests"):
            (folder / given).symlink_to(ROOT / given)
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        for commands in re.findall(r"^```sh\n(.*?)^```$", page, re.M | re.S):
            print(commands, end="")
            subprocess.run(["bash", "-euc", commands], cwd=folder, check=True, env=os.environ | {"PATH": path})
        for picture in re.findall(r"!\[[^\]]*\]\(([^)/]+)\)", page):
            keep(folder, Path(picture))
        schematics.draw(folder)  # of the theory's page
        keep(folder, Path("schematics.png"))


def keep(folder: Path, picture: Path) -> None:
    """Half the size and 256 colours, of which fewer gave lines those of others: a sixth of the bytes. Options in the
    name of a file are left out here."""
    drawn = min(folder.glob(f"{picture.stem}*{picture.suffix}"), key=lambda path: len(path.name))
    with Image.open(drawn) as full:
        half = full.convert("RGB").resize((full.width // 2, full.height // 2))
        half.quantize(256).save(HERE / picture.name, optimize=True)


if __name__ == "__main__":
    main()
