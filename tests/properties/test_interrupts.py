"""Ctrl-C at any moment, of any verb: one line and exit code 130, or the result."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

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
CASE = """
method = "{method}"
indenter = {{ shape = "paraboloid", radius = "1 mm" }}
specimen.{body}
loading = {{ radius = "0.1 mm", points = {points} }}
adhesion = {{ w = "50 mJ/m^2" }}
"""
HALF_SPACE = 'half_space = { E = "1 MPa", nu = 0.3 }'
LAYER = 'layers = [{ thickness = "0.2 mm", E = "1 MPa", nu = 0.3 }]'
SWEEP = """
base = "s.toml"
[[axes]]
key = "specimen.half_space.nu"
from = 0.1
to = 0.4
count = 400
"""
VERBS = {
    "new": ("new", "n.toml", "--force"),
    "check": ("check", "l.toml"),
    "run": ("run", "l.toml", "-o", "r.h5"),
    "import": ("import", "m.csv", "-o", "i.h5", "--radius", "1 mm", "--E", "1 MPa", "--nu", "0.3"),
    "mesh": ("mesh", "f.toml"),
    "transform": ("transform", "s.h5"),
    "pull-off": ("pull-off", "s.h5"),
    "cycle": ("cycle", "s.h5", "--rate", "v0=1 um/s,n=0.6", "--speed", "10 um/s"),
    "profile": ("profile", "s.h5", "--a", "50 um"),
    "fields": ("fields", "s.h5", "--a", "50 um"),
    "explore": ("explore", "s.h5"),
    "look": ("look", str(ROOT / "cases" / "measured" / "raw-force-curve.txt"), "-o", "."),
    "fit": ("fit", "s.h5", "m.csv"),
    "work": ("work", "s.h5", "m.csv"),
    "compare": ("compare", "s.h5", "s.h5"),
    "sweep": ("sweep", "many.toml", "-o", "r", "--workers", "2"),
    "study converge": ("study", "converge", "f.toml"),
    "study adhesion-map": ("study", "adhesion-map", "-o", "map"),
    "study pull-off-map": ("study", "pull-off-map", "-o", "map"),
    "study rate-map": ("study", "rate-map", "-o", "map"),
    "study sticking-map": ("study", "sticking-map", "-o", "map"),
    "study transition-map": ("study", "transition-map", "-o", "map"),
    "bench": ("bench", "s.toml"),
    "show": ("show", "s.h5"),
    "export": ("export", "s.h5", "--w", "50 mJ/m^2", "--dem"),
    "doctor": ("doctor",),
    "completion": ("completion", "bash"),
}


@pytest.fixture(name="folder")
def _folder(jkr, tmp_path: Path) -> Path:
    """What the verbs read."""
    bodies = ("s", "closed-form", HALF_SPACE, 20), ("l", "layered", LAYER, 100), ("f", "fem", HALF_SPACE, 20)
    for name, method, body, points in bodies:
        Path(f"{name}.toml").write_text(CASE.format(method=method, body=body, points=points))
    Path("many.toml").write_text(SWEEP)
    a = np.linspace(1e-5, 1e-4, 30)
    E_star = 1e6 / (1 - 0.3**2)
    table = np.column_stack([a, a**2 / 1e-3, 4 * E_star * a**3 / 3e-3, np.arange(30)])
    np.savetxt("m.csv", table, delimiter=",", header="a_m,delta_m,P_N,t_s", comments="")
    assert jkr("run", "s.toml").code == 0
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


def test_these_are_verbs() -> None:
    assert {words[0] for words in VERBS.values()} <= set(cli.VERBS)
    from jkrcli.many.verbs import study

    assert {words[1] for words in VERBS.values() if words[0] == "study"} <= set(study.list_commands(None))


def check(folder: Path, verb: str, moment: float) -> None:
    code, err = interrupted(folder, VERBS[verb], moment)
    if "Exception ignored" in err:
        return  # it met a callback, from which Python lets nothing out: who waits presses once more
    assert code in (0, CODE), (moment, code, err)
    assert "Traceback" not in err, (moment, err)
    assert code == 0 or err.endswith(LINE), (moment, err)


@pytest.mark.parametrize("verb", ["show", "sweep"])
@pytest.mark.parametrize("moment", [0.0, 0.4])
def test_an_interrupt_is_one_line(folder: Path, verb: str, moment: float) -> None:
    check(folder, verb, moment)


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
@pytest.mark.parametrize("verb", VERBS)
def test_interrupts_of_every_verb_are_one_line(folder: Path, verb: str) -> None:
    """From the moment jkrcli begins to be imported to 2 s later."""
    for moment in np.linspace(0, 2, 8).tolist():
        check(folder, verb, moment)


def test_the_exit_code_is_told() -> None:
    assert f"{CODE} interrupted (Ctrl-C)" in (cli.jkr.help or "")
