"""Whether what would be published works: the sdist, a wheel made of it, an empty environment, another folder.

python .ci/wheel.py build/wheels    # a folder of pinned packages: nothing else is installed from, no network
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = "import sys; from setuptools import build_meta; build_meta.build_sdist(sys.argv[1])"
SOLVED_AND_FITTED = """
jkr --version
jkr new my.toml
jkr run my.toml -o my.h5
jkr transform my.h5 --w 0.05 -o out
jkr fit my.h5 out/my-w0.05.csv -o out
jkr pull-off my.h5
jkr new --example gel
jkr new --example raw-force-curve
"""
EXPLORED = "jkr explore my.h5 -o my.html"
LEFT = ("my-w0.05.csv", "my-w0.05.json", "my-w0.05.png", "my-w0.05.svg", "my-fit.csv", "my-fit.json", "my-fit.h5")
EXAMPLES = "gel.toml", "raw-force-curve.txt"


def run(*words: str | Path, folder: Path = ROOT) -> None:
    """Run a command in ``folder`` without what would lead it to the sources; end where it fails."""
    print("+", *words, flush=True)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    if code := subprocess.run(list(map(str, words)), cwd=folder, env=environment, check=False).returncode:
        sys.exit(f"{words[0]}: exit code {code}")


def built() -> Path:
    """The wheel, made in dist of the sdist alone."""
    dist = ROOT / "dist"
    shutil.rmtree(dist, ignore_errors=True)
    dist.mkdir()
    run(sys.executable, "-c", BUILD, dist)
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index")
    run(sys.executable, "-m", "pip", "wheel", *options, "-w", dist, next(dist.glob("*.tar.gz")))
    return next(dist.glob("*.whl"))


def lacking(wheel: Path) -> list[str]:
    """Files of the package, as they stand here, that are not in the wheel."""
    here = [path.relative_to(ROOT).as_posix() for path in (ROOT / "jkrcli").rglob("*") if path.is_file()]
    held = set(zipfile.ZipFile(wheel).namelist())
    return sorted(name for name in here if name not in held and "__pycache__" not in name)


def main(packages: Path) -> None:
    wheel = built()
    if names := lacking(wheel):
        sys.exit(f"{wheel.name}: lacks {', '.join(names)}")
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder, "work")
        work.mkdir()
        venv.create(Path(folder, "venv"), with_pip=True)
        scripts = Path(folder, "venv", "Scripts" if os.name == "nt" else "bin")
        for extra, commands in (("", SOLVED_AND_FITTED), ("[explore]", EXPLORED)):
            source = ("--no-index", "--find-links", packages.resolve())
            run(scripts / "python", "-m", "pip", "install", "--quiet", *source, f"{wheel}{extra}")
            for line in commands.strip().splitlines():
                verb, *words = line.split()
                run(scripts / verb, *words, folder=work)
        left = [*(work / "out" / name for name in LEFT), *(work / name for name in EXAMPLES)]
        if names := [path.name for path in left if not path.exists()]:
            sys.exit(f"not written: {', '.join(names)}")
    print(f"{wheel.name}: builds, installs, solves, transforms, fits, explores")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
