"""Options without an effect on a kind of fit are refused by name, before anything is read or written."""

from collections.abc import Callable
from pathlib import Path

import pytest

import jkrcli.measured.verbs as verb
from jkrcli.measured.settings import EFFECT, GOES_WITH

GEL = Path(__file__).parents[2] / "cases" / "gel.toml"
KINDS = {"--law": ("--law", "power"), "--relaxation": ("--relaxation", "sls"), "--shared": ("--shared", "w"),
         "surface_tension": ("--free", "surface_tension"), "each": ()}  # fmt: skip
VALUES = {
    "law": "log", "relaxation": "sls", "terms": "2", "shared": "w", "own": "delta0", "tip_radius": "1 um",
    "start": "w=1 mJ/m^2", "bound": "w=..1", "segment": "retract", "base_line": "sine", "branch": "compressive",
    "noise": "P=1 nN", "loss": "huber", "confidence": "profile", "samples": "50", "seed": "3", "rivals": None,
    "plan": None, "model": "auto", "surface": "both", "uncertain": "radius=3%", "contact": "estimate",
    "slopes": "integral", "sample": "one", "report": None, "grid": "2x2",
}  # fmt: skip


KEEPS = ("law", "relaxation", "shared")  # each makes a kind of its own


def cases() -> list[tuple[str, str]]:
    """Kinds and options without an effect on them; the first of two kinds speaks."""
    first = {"--relaxation": KEEPS, "--law": ("law", "shared"), "surface_tension": ("shared",)}
    return [(kind, name) for kind in KINDS for name, kinds in EFFECT.items()
            if kind not in kinds and (name not in KEEPS or name in first.get(kind, ()))]  # fmt: skip


@pytest.mark.parametrize(("kind", "name"), cases())
def test_an_option_without_an_effect_is_refused(jkr: Callable, kind: str, name: str) -> None:
    Path("one.csv").write_text("delta (um),P (nN)\n" + "\n".join(f"{i},{i * i}" for i in range(20)))
    flag = f"--{name.replace('_', '-')}"
    words = (flag,) if VALUES[name] is None else (flag, VALUES[name])
    jkr("fit", GEL, "one.csv", *KINDS[kind], *words, "-o", ".").refused(flag)
    assert [path.name for path in Path().iterdir()] == ["one.csv"]


@pytest.mark.parametrize(
    "words",
    [("--samples", "50"), ("--seed", "1"), ("--relaxation", "sls", "--terms", "2"),
     ("--law", "power", "--contact", "fitted"), ("--rivals",)],
)  # fmt: skip
def test_options_that_go_with_others(jkr: Callable, words: tuple[str, ...]) -> None:
    made = Path(__file__).parents[2] / "cases" / "measured" / "gel-probe.csv"
    jkr("fit", GEL, made, *words, "-o", ".").refused("fit: ")
    assert not list(Path().iterdir())


def test_noise_of_what_was_not_measured(jkr: Callable) -> None:
    rows = "\n".join(f"{i / 10},{i**1.5 / 100}" for i in range(1, 21))
    Path("one.csv").write_text(f"delta (um),P (mN)\n{rows}\n")
    jkr("fit", GEL, "one.csv", "--noise", "a=1 um", "-o", ".").refused("--noise a: the file has no a")


def test_the_table_names_options_that_are_there() -> None:
    names = {option.name for option in verb.fit.params}
    assert set(EFFECT) <= names
    assert set(GOES_WITH) <= set(EFFECT)
