"""Files that come through a pipe: read once, as often as need be, under a name of their own."""

import gzip
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from conftest import Outcome

from jkrcli.base.errors import InputError
from jkrcli.base.files import received

CASE = """
method = "closed-form"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm", points = 20 }
adhesion.w = 0.05
"""


@pytest.fixture(name="measured")
def _measured(jkr: Callable[..., Outcome], tmp_path: Path) -> Path:
    Path("s.toml").write_text(CASE)
    assert jkr("run", "s.toml").code == 0
    a = np.linspace(2e-5, 9e-5, 40)
    P = 4e6 / 0.91 * a**3 / 3e-3 - np.sqrt(8 * np.pi * a**3 * 0.05e6 / 0.91)
    np.savetxt("m.csv", np.column_stack([a, P]), delimiter=",", header="a_m,P_N", comments="")
    for name in ("s.toml", "s.h5", "m.csv"):
        Path(f"{name}.gz").write_bytes(gzip.compress(Path(name).read_bytes()))
    return tmp_path


def shell(folder: Path, line: str) -> subprocess.CompletedProcess[str]:
    line = line.replace("jkr ", f"{sys.executable} -m jkrcli ")
    return subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.first(1)
@pytest.mark.parametrize(("line", "plain"), [
    ("jkr transform <(zcat s.h5.gz) --no-plots --json", "jkr transform s.h5 --no-plots --json"),
    ("zcat s.toml.gz | jkr check /dev/stdin --json", "jkr check s.toml --json"),
    ("jkr fit <(zcat s.h5.gz) <(zcat m.csv.gz) --no-plots --json", "jkr fit s.h5 m.csv --no-plots --json"),
])  # fmt: skip
def test_what_comes_through_a_pipe_is_what_the_file_gives(measured: Path, line: str, plain: str) -> None:
    piped, whole = shell(measured, line), shell(measured, plain)
    assert (piped.returncode, whole.returncode) == (0, 0), piped.stderr

    def numbers(out: str) -> list[str]:
        return [
            line for line in out.splitlines() if not any(name in line for name in ('"file', '"curve"', '"body', '"s'))
        ]

    assert len(numbers(whole.stdout)) > 5
    assert numbers(piped.stdout) == numbers(whole.stdout)


def test_a_record_through_a_pipe_is_looked_at_and_drawn_in_this_folder(measured: Path) -> None:
    raw = Path(__file__).parents[2] / "cases" / "measured" / "raw-force-curve.txt"
    done = shell(measured, f"cat '{raw}' | jkr look /dev/stdin")
    assert done.returncode == 0, done.stderr
    assert "stdin-look" in done.stdout
    assert (measured / "stdin-look.png").exists()


def test_a_pipe_without_end_is_refused(measured: Path, tuned: Callable[[str, object], None]) -> None:
    tuned("jkrcli.base.process.SIZE", 1 << 22)
    with subprocess.Popen(["cat", "/dev/zero"], stdout=subprocess.PIPE) as endless:
        path = Path(f"/dev/fd/{endless.stdout.fileno()}")
        with pytest.raises(InputError, match=r"/dev/fd/\d+: takes .* bytes or more to read, at most 4,194,304"):
            received(path)
        endless.kill()
