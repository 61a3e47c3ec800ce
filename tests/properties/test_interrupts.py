"""Ctrl-C at any moment, of any verb: one line and exit code 130, or the result."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from every_verb import BASES, verb_of, write_inputs

from jkrcli import cli

ROOT = Path(__file__).parents[2]
CODE, LINE = 130, "jkr: error: interrupted; nothing half-written was left\n"
READY = """
import os, sys
from jkrcli.__main__ import main
def told(event, _, at=[]):  # with the first module; the milliseconds in which Python finds the package are its own
    if event == "import" and not at:
        at.append(os.write(1, b"."))
sys.addaudithook(told)
sys.argv[0] = "jkr"
main()
"""
MANY = """
base = "gel.toml"
[[axes]]
key = "specimen.layers[0].nu"
from = 0.1
to = 0.4
count = 400
"""
WORDS = {
    **BASES,
    "sweep": ("many.toml", "-o", "r", "--workers", "2"),
    "new": ("mine.toml", "--force"),
    "completion": ("bash",),
}


@pytest.fixture(name="folder")
def _folder(jkr, tmp_path: Path) -> Path:
    write_inputs(tmp_path, jkr)
    Path("many.toml").write_text(MANY)
    return tmp_path


def interrupted(folder: Path, words: tuple[str, ...], seconds: float) -> tuple[int, str]:
    """Exit code and stderr of a command to which Ctrl-C is sent, and to the processes that it started, as a terminal
    does it, so many ``seconds`` after jkrcli began to be imported."""
    command, pipe = [sys.executable, "-c", READY, *words], subprocess.PIPE
    process = subprocess.Popen(command, cwd=folder, stdout=pipe, stderr=pipe, text=True, start_new_session=True)
    process.stdout.read(1)
    try:
        _, err = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=120)
    return process.returncode, err


def check(folder: Path, base: str, moment: float) -> None:
    code, err = interrupted(folder, (*verb_of(base).split(), *WORDS[base]), moment)
    if "Exception ignored" in err:
        return  # it met a callback, from which Python lets nothing out: who waits presses once more
    done = code == 0 or (verb_of(base) == "compare" and code == 1)  # 1: the files differ
    assert done or code == CODE, (moment, code, err)
    assert "Traceback" not in err, (moment, err)
    assert done or err.endswith(LINE), (moment, err)


def test_an_interrupt_is_one_line(folder: Path) -> None:
    for base, moment in (("show", 0.0), ("show", 0.4), ("sweep", 0.4)):
        check(folder, base, moment)


@pytest.mark.parametrize(
    ("moment", "code", "words"),
    [
        # Python answers for what a class calls while it is made with a RuntimeError of its own
        ("cli.call = lambda: type('Half', (), {'read': type('', (), {'__set_name__': press})()})", CODE, LINE),
        # as C code does that is initialised then
        ("def call():\n try: press()\n except KeyboardInterrupt: raise ImportError('initialization failed')\n"
         "cli.call = call", CODE, LINE),
        # and what was loaded by half need not survive that Python clears up
        ("import atexit; atexit.register(os.abort)\ncli.call = lambda: cli.INTERRUPTED", CODE, ""),
        # while all that is done is cleared up there is nothing to interrupt
        ("import atexit; atexit.register(press)\ncli.call = lambda: 0", 0, ""),
    ],
    ids=["class", "module", "clearing-up-half", "clearing-up"],
)  # fmt: skip
def test_an_interrupt_where_python_turns_it_into_another_error(moment: str, code: int, words: str) -> None:
    program = (
        "import os, signal\nfrom jkrcli import cli\nfrom jkrcli.__main__ import main\n"
        f"def press(*_): os.kill(os.getpid(), signal.SIGINT)\n{moment}\nmain()\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (code, words)


@pytest.mark.slow
@pytest.mark.parametrize("base", WORDS)
def test_interrupts_of_every_verb_are_one_line(folder: Path, base: str) -> None:
    """From the moment jkrcli begins to be imported to 2 s later."""
    for moment in np.linspace(0, 2, 8).tolist():
        check(folder, base, moment)


def test_the_exit_code_is_told() -> None:
    assert f"{CODE} interrupted (Ctrl-C)" in (cli.jkr.help or "")
