"""What every verb prints: a verdict, at most ten lines behind it, the rest with -v; no line wider than the terminal.

Of text that is printed as it is, a script or a case, that does not hold: ``completion``, ``show --case``.
"""

from collections.abc import Callable

import pytest
from every_verb import BASES, options_of, verb_of, write_inputs

from jkrcli.cli import printing as output

CHEAP = ("new", "check", "run", "transform", "pull-off", "export", "look", "show")
ALL = [*(base for base in BASES if ":" not in base), "pull-off:load", "cycle:rate", "fit:raw"]


def judge(jkr: Callable, words: tuple[object, ...], whole: list[str]) -> None:
    """``whole``: what was said, before it was folded."""
    done = jkr(*words)
    assert done.code == (words[0] == "compare"), done.err
    wide = [line for line in (done.out + done.err).splitlines() if len(line) > 80]
    assert [line for line in wide if len(line.split()) > 1 and max(map(len, line.split())) < 76] == []
    lines = done.out.splitlines()
    assert len(lines) <= (16 if words[0] == "check" else 12), done.out
    verdict = next((line for line in whole if line.strip() and line.startswith(lines[0].rstrip())), lines[0])
    assert any(character.isdigit() for character in verdict) or words[0] in ("new", "check", "study"), verdict
    assert len(verdict) <= 120
    if any(line.endswith(" with -v") for line in lines) and words[0] in ("pull-off", "show"):
        assert len(jkr(*words, "-v").out.splitlines()) > len(lines)


@pytest.mark.parametrize("bases", [CHEAP, pytest.param(ALL, marks=pytest.mark.slow)], ids=["", "all"])
def test_the_verdict_comes_first(jkr, monkeypatch, tmp_path, bases) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    write_inputs(tmp_path, jkr)
    whole: list[str] = []
    fold = output.folded
    monkeypatch.setattr(output, "folded", lambda line, *widest: (whole.append(line), fold(line, *widest))[1])
    for base in bases:
        whole.clear()
        plots = ["--no-plots"] * any("--no-plots" in option.opts for option in options_of(base))
        judge(jkr, (*verb_of(base).split(), *(word for word in BASES[base] if word != "--json"), *plots), whole)


def test_errors_are_one_line_in_a_log(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    done = jkr("check", "there-is-no-such-case-file-in-this-empty-folder-of-a-test.toml")
    assert (done.code, len(done.err.splitlines())) == (2, 1)
