"""Files that come through a pipe: read once, as often as need be, under a name of their own."""

import gzip
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Outcome
from every_verb import write_inputs

from jkrcli.base.errors import InputError
from jkrcli.base.files import received


@pytest.fixture(name="measured")
def _measured(jkr: Callable[..., Outcome], tmp_path: Path) -> Path:
    write_inputs(tmp_path, jkr)
    for name in ("gel.toml", "gel.h5", "probe.csv"):
        Path(f"{name}.gz").write_bytes(gzip.compress(Path(name).read_bytes()))
    return tmp_path


def shell(folder: Path, line: str) -> subprocess.CompletedProcess[str]:
    line = line.replace("jkr ", f"{sys.executable} -m jkrcli ")
    return subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True, text=True, check=False)


@pytest.mark.first(2)
@pytest.mark.parametrize(("line", "plain"), [
    ("jkr transform <(zcat gel.h5.gz) --no-plots --json", "jkr transform gel.h5 --no-plots --json"),
    ("zcat gel.toml.gz | jkr check /dev/stdin --json", "jkr check gel.toml --json"),
    ("jkr fit <(zcat gel.h5.gz) <(zcat probe.csv.gz) --no-plots --json", "jkr fit gel.h5 probe.csv --no-plots --json"),
])  # fmt: skip
def test_what_comes_through_a_pipe_is_what_the_file_gives(measured: Path, line: str, plain: str) -> None:
    piped, whole = shell(measured, line), shell(measured, plain)
    assert (piped.returncode, whole.returncode) == (0, 0), piped.stderr

    def numbers(out: str) -> list[str]:
        named = '"file', '"case"', '"curve"', '"body', '"s'
        return [line for line in out.splitlines() if not any(name in line for name in named)]

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
