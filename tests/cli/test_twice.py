"""Every verb that writes recognises its own files: run again with the same words, it replaces them."""

import shutil
from pathlib import Path

import pytest

CASES = Path(__file__).parents[2] / "cases"
PROBE = "cases/measured/gel-probe.csv"
FAST = ("transform", "cycle", "profile", "fit", "work", "export")
RATE = ("--w-retract", "0.04", "--rate", "v0=1um/s,n=0.6", "--speed", "10um/s")
VERBS = {
    "run": ("run", "cases/thin-layer.toml", "-o", "o/thin.h5"),
    "transform": ("transform", "gel.h5", "--w", "0.03", "--w", "0.04", "--together"),
    "transform, finite range": ("transform", "gel.h5", "--w", "0.04", "--stress", "1 MPa"),
    "transform, dimensionless": ("transform", "gel.h5", "--w", "0.04", "--dimensionless", "thin-layer"),
    "profile of a surface that sticks": ("profile", "cases/stuck.toml", "--a", "0.5 mm"),
    "profile": ("profile", "gel.h5", "--a", "0.5 mm"),
    "fields": ("fields", "gel.h5", "--a", "0.5 mm"),
    "cycle": ("cycle", "gel.h5"),
    "cycle, load control": ("cycle", "gel.h5", "--stiffness", "load"),
    "cycle over time": ("cycle", "gel.h5", *RATE),
    "cycle over time, load control": ("cycle", "gel.h5", *RATE[:-1], "1 uN/s", "--stiffness", "load"),
    "work": ("work", "cases/gel.toml", PROBE),
    "fit": ("fit", "cases/gel.toml", PROBE),
    "look": ("look", PROBE),
    "export": ("export", "gel.h5", "--dem"),
    "explore": ("explore", "gel.h5", "-o", "o/gel.html"),
    "compare": ("compare", "gel.h5", "gel.h5", "--plot", "o/same.svg"),
    "mesh": ("mesh", "cases/halfspace.toml"),
    "bench": ("bench", "cases/thin-layer.toml"),
    "pull-off-map": ("study", "pull-off-map", "--nu", "0.3"),
    "converge": ("study", "converge", "cases/thin-layer.toml"),
    "transition-map": ("study", "transition-map", "--q", "1", "--mu", "1"),
    "rate-map": ("study", "rate-map", "--speed", "0.1", "--speed", "1", "--stiffness", "rigid"),
    "roughness-map": ("study", "roughness-map", "--rms", "9 nm", "--modulus", "1 MPa"),
    "sticking-map": ("study", "sticking-map", "--nu", "0.4", "--ratio", "1"),
}


@pytest.mark.first(len(FAST))
@pytest.mark.parametrize("name", sorted(VERBS, key=lambda name: name not in FAST))
def test_a_verb_replaces_what_it_wrote(name: str, jkr, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(CASES, tmp_path / "cases")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "o").mkdir()
    gel = Path("cases/gel.toml").read_text()
    Path("cases/stuck.toml").write_text(gel.replace("[specimen]", '[specimen]\nsurface = "sticking"', 1))
    words = VERBS[name]
    if "gel.h5" in words:
        assert jkr("run", "cases/gel.toml", "-o", "gel.h5").code == 0
    target = () if "-o" in words or name in ("bench", "compare") else ("-o", "o")
    for _ in range(2):
        assert jkr(*words, *target).code == 0
    kept = [path for path in (tmp_path / "o").rglob("*") if path.is_file()]
    assert kept or name == "bench"
    for path in kept:  # and the user's own files are his
        path.write_text("mine\n")
    if kept:
        assert jkr(*words, *target).code == 2
        assert all(path.read_text() == "mine\n" for path in kept)
