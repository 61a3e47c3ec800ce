"""The studies, as verbs and as make runs them: small ones, from start to file."""

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


def test_workers_and_scheduler_exclude_each_other(study) -> None:
    study("failures", "--cells", 1, "--workers", 2, "--scheduler", "tcp://node:8786").refused(
        "give either --workers or --sched"
    )
