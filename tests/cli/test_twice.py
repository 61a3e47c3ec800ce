"""Every verb that writes recognises its own files: run again with the same words, it replaces them."""

from collections.abc import Callable
from pathlib import Path

import pytest
from every_verb import BASES, left, verb_of, write_inputs

FAST = ("transform", "cycle", "profile", "fit", "work", "export")
SILENT = (
    "new",
    "check",
    "pull-off",
    "show",
    "bench",
    "doctor",
    "compare:curves",
)  # write nothing, or no file that is replaced
WORDS = {
    **{base: words for base, words in BASES.items() if not {base, verb_of(base)} & {*SILENT}},
    "transform": ("gel.h5", "--w", "0.03", "--w", "0.04", "--together"),
    "cycle:load control": ("gel.h5", "--stiffness", "load"),
    "compare": ("gel.h5", "gel.h5", "--plot", "same.svg"),
}


@pytest.mark.first(len(FAST))
@pytest.mark.parametrize("base", sorted(WORDS, key=lambda base: base not in FAST))
def test_a_verb_replaces_what_it_wrote(base: str, jkr: Callable, tmp_path: Path) -> None:
    write_inputs(tmp_path, jkr)
    before = left(tmp_path)
    words = (*verb_of(base).split(), *WORDS[base])
    for _ in range(2):
        assert jkr(*words).code == 0
    made = [tmp_path / name for name, content in left(tmp_path).items() if content != before.get(name)]
    assert made
    for path in made:  # and the user's own files are his
        path.write_text("mine\n")
    assert jkr(*words).code == 2
    assert all(path.read_text() == "mine\n" for path in made)
