"""Makes the tables beside it from test data of afmformats: ``python thin.py FOLDER``, its ``tests/data``.

Every third row of the measured height and the force, as the file has them; nothing else is changed.
"""

import sys
from pathlib import Path

import afmformats
import numpy as np

EVERY = 3
FILES = {"gel.csv": "fmt-tab-fd_version_0.13.3.tab", "spot.csv": "fmt-jpk-fd_spot3-0192.jpk-force"}
HEAD = """# {file} of the test data of afmformats, github.com/AFM-analysis/afmformats, commit 731b5ad
# Copyright (c) 2019 Paul Müller, MIT licence, see LICENSE beside this file; every third row, by thin.py
# springConstant: {k!r}
height (measured) [um],force [nN],segment
"""


def main(folder: Path) -> None:
    for name, file in FILES.items():
        (data,) = afmformats.load_data(folder / file)
        height, force = data["height (measured)"][::EVERY] * 1e6, data["force"][::EVERY] * 1e9
        words = np.where(np.asarray(data["segment"], dtype=int)[::EVERY] == 0, "approach", "retract")
        rows = (f"{z:.5f},{P:.5f},{word}\n" for z, P, word in zip(height, force, words, strict=True))
        head = HEAD.format(file=file, k=float(data.metadata["spring constant"]))
        Path(__file__).with_name(name).write_text(head + "".join(rows))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
