"""What every verb prints: a verdict, at most ten lines behind it, the rest with -v; no line wider than the terminal.

Of text that is printed as it is, a script or a case, that does not hold: ``completion``, ``show --case``.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

from jkrcli.cli import printing as output

CASES = Path(__file__).parents[2] / "cases"
GEL, RECORD, PROBE = (
    CASES / "gel.toml",
    CASES / "measured" / "raw-force-curve.txt",
    CASES / "measured" / "gel-probe.csv",
)
TABLE = "a_m,delta_m,P_N\n" + "\n".join(f"{a},{a**2 / 6e-3},{1e4 * a**3}" for a in (2e-4, 3e-4, 4e-4, 5e-4, 6e-4, 7e-4))
SWEEP = f"""
base = "{GEL}"
axes = [{{ key = "specimen.layers[0].nu", values = [0.3, 0.4] }}]
"""
WORDS: tuple[tuple[object, ...], ...] = (
    ("new", "my.toml"), ("check", GEL), ("run", GEL, "-o", "gel.h5"), ("transform", "gel.h5", "--no-plots"),
    ("pull-off", "gel.h5", "--w", "0.04"), ("export", "gel.h5", "--dem"), ("look", RECORD, PROBE, "--no-plots"),
    ("show", "gel.h5"),
)  # fmt: skip
DEAR: tuple[tuple[object, ...], ...] = (
    ("run", GEL, "-o", "gel.h5"), ("import", "table.csv", "--case", GEL, "-o", "table.h5"), ("mesh", GEL),
    ("pull-off", "gel.h5"), ("pull-off", "gel.h5", "--load", "1.2 mN"), ("cycle", "gel.h5", "--no-plots"),
    ("cycle", "gel.h5", "--rate", "v0=1 um/s,n=0.6", "--speed", "10 um/s", "--to-load", "0.5 mN", "--no-plots"),
    ("profile", "gel.h5", "--load", "0.5 mN"), ("fields", "gel.h5", "--load", "0.5 mN"), ("explore", "gel.h5"),
    ("fit", RECORD, "--radius", "5 um", "--nu", "0.5", "-o", "fitted", "--no-plots"),
    ("fit", "gel.h5", PROBE, PROBE, "--no-plots"), ("work", "gel.h5", PROBE, "-o", "work", "--no-plots"),
    ("compare", "gel.h5", "gel.h5"), ("sweep", "sweep.toml", "-o", "swept"),
    ("study", "pull-off-map", "--q", "1", "--nu", "0.3", "--no-plots"),
    ("study", "converge", GEL, "--levels", "2", "--no-plots"), ("bench", GEL, "--repeat", "1"), ("doctor",),
)  # fmt: skip


def judge(jkr: Callable, words: tuple[object, ...], whole: list[str]) -> None:
    """``whole``: what was said, before it was folded."""
    done = jkr(*words).ok
    wide = [line for line in (done.out + done.err).splitlines() if len(line) > 80]
    assert [line for line in wide if len(line.split()) > 1 and max(map(len, line.split())) < 76] == []
    lines = done.out.splitlines()
    assert len(lines) <= (16 if words[0] == "check" else 12), done.out
    verdict = next((line for line in whole if line.strip() and line.startswith(lines[0].rstrip())), lines[0])
    assert any(character.isdigit() for character in verdict) or words[0] in ("new", "check", "study"), verdict
    assert len(verdict.replace(f"{CASES}/measured/", "")) <= 120
    if any(line.endswith(" with -v") for line in lines) and words[0] in ("pull-off", "show"):
        assert len(jkr(*words, "-v").out.splitlines()) > len(lines)


@pytest.mark.parametrize("words", [WORDS, pytest.param(DEAR, marks=pytest.mark.slow)], ids=["", "dear"])
def test_the_verdict_comes_first(
    jkr: Callable, monkeypatch: pytest.MonkeyPatch, words: tuple[tuple[object, ...], ...]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    Path("table.csv").write_text(TABLE)
    Path("sweep.toml").write_text(SWEEP)
    whole: list[str] = []
    fold = output.folded
    monkeypatch.setattr(output, "folded", lambda line, *widest: (whole.append(line), fold(line, *widest))[1])
    for line in words:
        if line[0] == "explore":
            pytest.importorskip("plotly")
        whole.clear()
        judge(jkr, line, whole)


def test_errors_are_one_line_in_a_log(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    done = jkr("check", "there-is-no-such-case-file-in-this-empty-folder-of-a-test.toml")
    assert (done.code, len(done.err.splitlines())) == (2, 1)
