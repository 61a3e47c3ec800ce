"""The studies, as verbs and as make runs them: small ones, from start to file."""

import csv
from pathlib import Path

import pytest

from jkrcli.many.verbs import MAKE


def test_unknown_study_is_named(jkr) -> None:
    jkr("study", "nois").refused('unknown study "nois" (studies: ')


SCRIPTS = {"figures": "paper"}  # that have another name than the study had


@pytest.mark.parametrize(("name", "target"), MAKE.items())
def test_a_study_that_left_is_found_in_make(jkr, name: str, target: str) -> None:
    jkr("study", name, "--seeds", 2).refused(f'"{name}" is now run as make {target}; see jkr study --help')
    lines = (Path(__file__).parents[2] / "Makefile").read_text()
    assert f"$(STUDY).{SCRIPTS.get(name, name)} " in lines[lines.index(f"\n{target}:") :]


@pytest.mark.parametrize("name", [*MAKE, "tuning"])
def test_studies_run_by_make_have_help(study, capsys: pytest.CaptureFixture[str], name: str) -> None:
    with pytest.raises(SystemExit, match="0"):
        study(SCRIPTS.get(name, name), "--help")
    assert "--output OUTPUT" in capsys.readouterr().out


def several(option: str, low: float, high: float, count: int) -> list[str]:
    return [word for i in range(count) for word in (option, f"{low + (high - low) * i / count:g}")]


LONG = {
    "rate-map": (several("--speed", 0.01, 1, 200), "rate map: about 60 s"),
    "transition-map": ([], "transition map: about 13 s"),
    "adhesion-map": (several("--mu", 0.1, 10, 100), "adhesion map: about 6.5 s"),
    "sticking-map": (several("--nu", 0, 0.5, 40), "sticking map: about 10 s"),
    "pull-off-map": (several("--q", 0.1, 1, 5000), "pull-off map: about 10 s"),
}


@pytest.mark.parametrize("name", LONG)
def test_a_long_map_is_announced_where_no_bar_is_shown(jkr, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """200 speeds took a minute without a word."""

    def begun(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("jkrcli.base.executors._Here.submit", begun)
    words, said = LONG[name]
    done = jkr("study", name, *words, "--workers", "1", "--no-plots")
    assert (done.code, done.err.splitlines()[0]) == (130, f"jkr: {said} of CPU time")


@pytest.mark.slow
def test_studies_do_not_depend_on_the_number_of_workers(jkr, study) -> None:
    words = ("noise", "--seeds", 2, "--body", "layer-0.4", "--points", 30)
    maps = ("study", "pull-off-map", "--nu", 0.3, "--nu", 0.45, "--q", 0.1, "--q", 1, "--no-plots")
    for workers in (1, 2):
        assert study(*words, "--workers", workers, "-o", f"by-{workers}").code == 0
        assert jkr(*maps, "--workers", workers, "-o", f"by-{workers}").code == 0
    for name in ("noise-study.csv", "pull-off-map.csv"):
        assert Path("by-1", name).read_text() == Path("by-2", name).read_text()


def test_workers_and_scheduler_exclude_each_other(study) -> None:
    study("failures", "--cells", 1, "--workers", 2, "--scheduler", "tcp://node:8786").refused(
        "give either --workers or --sched"
    )


@pytest.mark.slow
def test_noise_study_writes_its_table_and_picture(study, tmp_path: Path) -> None:
    words = ("noise", "--seeds", 2, "--body", "hertz", "--points", 30, "-o", "out")
    assert study(*words).code == 0
    names = {"noise-hertz.png", "noise-hertz.svg", "noise-study.csv"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == names
    rows = list(csv.DictReader((tmp_path / "out" / "noise-study.csv").read_text().splitlines()))
    assert len({(row["method"], row["noise"]) for row in rows}) == 3 * 5
    fitted = {row["noise"]: float(row["median"]) for row in rows if row["method"] == "integral"}
    assert fitted["0.0"] < 1e-9  # a power law is exact
    assert fitted["0.0001"] < 1e-3  # 4e-5 in the median of many seeds
    assert not any(word in (tmp_path / "out" / "noise-study.csv").read_text() for word in ("nan", "inf"))
    assert study(*words).code == 0  # its own files are replaced
