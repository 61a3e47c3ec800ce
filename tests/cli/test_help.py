"""Help, the doctor and shell completion: what a user meets before anything is solved."""

import importlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import click
import pytest
from every_verb import BASES, verb_of, write_inputs

from jkrcli.base.errors import installs
from jkrcli.cli import GROUPS, RARE, VERBS
from jkrcli.cli import jkr as root
from jkrcli.cli.options import DESCRIBED, LINES
from jkrcli.fem.mesh import SYSTEM_PACKAGES
from jkrcli.many.verbs import STUDIES
from jkrcli.report import check as doctor

BIN = Path(sys.executable).parent


def test_help_lists_every_verb_in_a_group(jkr: Callable) -> None:
    """With --all; without it what is rarely typed is not in the way."""
    usual, every = jkr("--help").out, jkr("--help", "--all").out
    assert usual.index("\n  new ") < usual.index("\n  fit ") < usual.index("\n  cycle ")
    for title, verbs in GROUPS.items():
        assert f"\n{title}:\n" in every
        for verb in verbs:
            assert f"\n  {verb} " in every
            assert (f"\n  {verb} " in usual) == (verb not in RARE)


COMMANDS = [*((verb,) for verb in VERBS), *(("study", name) for name in STUDIES)]


@pytest.mark.parametrize("words", [(), *COMMANDS])
def test_help_fits_two_screens_and_shows_an_example(jkr, monkeypatch, words) -> None:
    """Two screens of 40 lines and 80 columns; at most twelve options are described, the others named."""
    monkeypatch.setenv("COLUMNS", "80")
    text = jkr(*words, "--help").ok.out
    assert len(text.splitlines()) <= LINES
    assert [line for line in text.splitlines() if len(line) > 80] == []
    assert f"\n  {' '.join(('jkr', *words))}" in text
    if words not in ((), ("study",)):
        parts = (re.split(r"\n\w+:\n", each, maxsplit=1)[-1] for each in (text, jkr(*words, "--help-all").out))
        few, every = (set(re.findall(r"^  (?:-., )?(--[a-zA-Z-]+)", each, re.MULTILINE)) for each in parts)
        assert len(few) <= 12
        first = text.partition("\nOptions:\n")[2].partition("\n\n")[0]  # what everybody needs
        assert not re.search("^ *(--limit-memory|--json|--column) ", first, re.MULTILINE)
        assert few <= every <= set(re.findall(r"--[a-zA-Z-]+", text))
        assert few == every or "--help-all" in text


@pytest.mark.parametrize("verb", VERBS)
def test_every_option_says_what_it_does_and_what_is_described_is_one(verb: str) -> None:
    options = [one for one in root.get_command(click.Context(root), verb).params if isinstance(one, click.Option)]
    assert [one.opts for one in options if not one.help] == []
    described = set(DESCRIBED.get(verb, "").split()) - {"help"}
    assert described <= {name.removeprefix("--") for one in options for name in one.opts}


@pytest.mark.parametrize("verb", VERBS)
def test_what_writes_files_alone_can_be_told_to_be_quiet(jkr: Callable, verb: str) -> None:
    told = jkr(verb, "--help-all").out
    assert ("-q, --quiet" in told) == ("--force" in told)


@pytest.mark.slow
def test_quiet_verbs_say_nothing_but_warnings(jkr: Callable, tmp_path: Path) -> None:
    write_inputs(tmp_path, jkr)
    for base in BASES:
        context = click.Context(root)
        command = root.get_command(context, verb_of(base).split()[0])
        if any("--quiet" in option.opts for option in getattr(command, "params", ())):
            done = jkr(*verb_of(base).split(), *(word for word in BASES[base] if word != "--json"), "-q")
            assert (done.code, done.out) == (verb_of(base) == "compare", ""), base
            assert all(text.startswith("jkr: warning: ") for text in done.err.splitlines()), done.err


def test_doctor_finds_this_machine_sound(jkr: Callable) -> None:
    done = jkr("doctor", "--json")
    report = json.loads(done.out)
    assert (done.code, report["sound"]) == (0, True)
    assert {"Python", "numpy", "gmsh", "scikit-fem"} <= {f["part"] for f in report["findings"]}


def test_doctor_names_the_remedy_of_what_is_missing(jkr: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    real = importlib.import_module

    def without_gl(name: str) -> object:
        if name == "gmsh":
            raise OSError("libGLU.so.1: cannot open shared object file")
        return real(name)

    assert SYSTEM_PACKAGES in (Path(__file__).parents[2] / ".ci" / "system-libraries").read_text()
    monkeypatch.setattr(importlib, "import_module", without_gl)
    monkeypatch.setitem(doctor.OPTIONAL, "no-such-package", ("nothing", "a test"))
    done = jkr("doctor")
    assert done.code == 1
    assert "MISSING   gmsh             cannot load: libGLU.so.1" in done.out
    assert f"type: sudo apt-get install --no-install-recommends {SYSTEM_PACKAGES}" in done.out
    assert f"optional  no-such-package  not installed (a test); type: {installs('nothing')}" in done.out


def completed(shell: str, script: str) -> list[str]:
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"{shell} is not installed")
    environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
    done = subprocess.run([program, "-c", script], capture_output=True, text=True, timeout=60, env=environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


@pytest.mark.slow
def test_completion_works_in_bash() -> None:
    words = (
        'eval "$(jkr completion bash)"; COMP_WORDS=({}); COMP_CWORD={}; _jkr_completion jkr; echo "${{COMPREPLY[@]}}"'
    )
    assert set(completed("bash", words.format("jkr p", 1))) == {v for v in VERBS if v.startswith("p")}
    assert "--slopes" in completed("bash", words.format("jkr transform --s", 2))
    assert completed("bash", words.format("jkr transform --slopes lo", 3)) == ["loocv", "loocv-kept", "loocv-smoothed"]


@pytest.mark.slow
def test_completion_works_in_zsh() -> None:
    loaded = (
        'autoload -Uz compinit; compinit -u -d /dev/null; eval "$(jkr completion zsh)"; '
        "whence -w _jkr_completion; print -r -- ${_comps[jkr]}"
    )
    assert completed("zsh", loaded) == ["_jkr_completion:", "function", "_jkr_completion"]
    asked = "COMP_WORDS='jkr transform --slopes in' COMP_CWORD=3 _JKR_COMPLETE=zsh_complete jkr"
    assert "integral" in completed("zsh", asked)
