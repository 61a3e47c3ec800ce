"""Ctrl-C at any moment, of any verb: one line and exit code 130, or the result."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from jkrcli import cli
from jkrcli.base import interrupts

ROOT = Path(__file__).parents[2]
LINE = f"jkr: error: {interrupts.SAID}\n"
READY = """
import os, sys
from jkrcli.base.interrupts import leave_at_once
leave_at_once()  # what jkrcli.__main__ does first; the millisecond in which Python finds the package is Python's own
os.write(1, b".")
from jkrcli.__main__ import main
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
    for name, method, body, points in (
        ("s", "closed-form", HALF_SPACE, 20),
        ("l", "layered", LAYER, 100),
        ("f", "fem", HALF_SPACE, 20),
    ):
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
    assert process.stdout is not None
    process.stdout.read(1)
    try:
        _, err = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=120)
    return process.returncode, err


@pytest.mark.parametrize("verb", ["transform", "cycle", "profile", "fields", "fit", "work", "export"])
def test_a_verb_replaces_its_own_files_without_force(jkr, folder: Path, verb: str) -> None:
    """Each kind of table is known by its first columns."""
    for _ in range(2):
        assert jkr(*VERBS[verb], *(() if verb in ("profile", "export") else ("--no-plots",))).code == 0


def test_every_verb_is_among_them() -> None:
    assert {words[0] for words in VERBS.values()} == set(cli.VERBS)
    from jkrcli.cli.study_verbs import study

    assert {words[1] for words in VERBS.values() if words[0] == "study"} == set(study.list_commands(None))


def check(folder: Path, verb: str, moment: float) -> None:
    code, err = interrupted(folder, VERBS[verb], moment)
    assert code in (0, interrupts.CODE), (moment, code, err)
    assert "Traceback" not in err, (moment, err)
    assert "KeyboardInterrupt" not in err, (moment, err)
    assert code == 0 or err.endswith(LINE), (moment, err)


@pytest.mark.parametrize("verb", ["show", "sweep"])
@pytest.mark.parametrize("moment", [0.0, 0.4])
def test_an_interrupt_is_one_line(folder: Path, verb: str, moment: float) -> None:
    check(folder, verb, moment)


@pytest.mark.slow
@pytest.mark.parametrize("verb", VERBS)
def test_interrupts_at_forty_moments_are_one_line(folder: Path, verb: str) -> None:
    """From the moment jkrcli begins to be imported to 2 s later."""
    for moment in np.linspace(0, 2, 40).tolist():
        check(folder, verb, moment)


def test_an_interrupt_before_it_is_minded_is_one_line() -> None:
    """While the module that minds it is imported itself; what comes before is Python's own start."""
    code = """
import importlib.abc, signal, sys
class Interrupted(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "jkrcli.base.interrupts":
            signal.raise_signal(signal.SIGINT)
sys.meta_path.insert(0, Interrupted())
import jkrcli.__main__
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (interrupts.CODE, LINE)


def test_an_interrupt_within_an_import_waits_for_its_end() -> None:
    """A compiled module makes an ImportError of it: half a library would be missing, and a traceback printed."""
    code = """
import importlib.abc, importlib.util, signal, sys, time
from jkrcli.base import interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)
interrupts.leave_at_once(); interrupts.raise_from_here()
class Compiled(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path, target=None):
        return importlib.util.spec_from_loader(name, self) if name == "compiled" else None
    def create_module(self, spec):
        return None
    def exec_module(self, module):
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            raise ImportError("initialization failed") from None
        module.whole = True
sys.meta_path.insert(0, Compiled())
try:
    import compiled
    print(compiled.whole, flush=True)
    time.sleep(10)
    print("lost")
except KeyboardInterrupt:
    print("caught")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("True\ncaught\n", "")


def test_an_interrupt_waits_while_processes_are_started() -> None:
    """A process that is not told what to do ends in a traceback; one sent by a thread is not held up by a mask."""
    code = """
import os, signal, threading, time
from jkrcli.base import interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)
interrupts.leave_at_once(); interrupts.raise_from_here()
threading.Thread(target=lambda: (time.sleep(0.05), os.kill(os.getpid(), signal.SIGINT))).start()
try:
    with interrupts.Waiting():
        time.sleep(0.2)
        print("whole", flush=True)
    time.sleep(10)
    print("lost")
except KeyboardInterrupt:
    print("caught")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("whole\ncaught\n", "")


def test_what_compiled_code_makes_of_an_interrupt_is_told_as_one(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pydantic's core makes a SchemaError of a Ctrl-C while it builds a model."""

    def build(*_: object, **__: object) -> None:
        try:
            interrupts._raise(signal.SIGINT, None)
        except KeyboardInterrupt:
            raise RuntimeError("SchemaError") from None

    monkeypatch.setattr("jkrcli.base.interrupts._came", False)
    monkeypatch.setattr("jkrcli.cli.help_verbs.read_series", build)
    assert (cli.call(["show", "x.h5"]), capsys.readouterr().err) == (interrupts.CODE, LINE)


def test_an_interrupt_within_a_destructor_is_not_lost() -> None:
    code = (
        "import signal, time\nfrom jkrcli.base import interrupts\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "interrupts.leave_at_once(); interrupts.raise_from_here()\n"
        "class Held:\n    def __del__(self): signal.raise_signal(signal.SIGINT)\n"
        "try:\n    held = Held(); del held; time.sleep(10); print('lost')\n"
        "except KeyboardInterrupt: print('caught')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("caught\n", "")


def test_little_is_imported_before_interrupts_are_minded() -> None:
    """What is imported until then is the time in which Ctrl-C is the interpreter's own."""
    code = "import sys; before = set(sys.modules); import jkrcli.__main__; print(*sorted(set(sys.modules) - before))"
    found = subprocess.run([sys.executable, "-S", "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    ours = [name for name in found.stdout.split() if name.startswith("jkrcli")]
    assert ours == ["jkrcli", "jkrcli.__main__", "jkrcli.base", "jkrcli.base.interrupts", "jkrcli.base.lazy"]
    assert "typing" not in found.stdout.split()


def test_an_interrupt_behind_the_last_word_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Signals that wait are delivered when the handler is changed: there the exception comes out."""
    waiting = [KeyboardInterrupt()]

    def ignore() -> None:
        if waiting:
            raise waiting.pop()

    monkeypatch.setattr("jkrcli.base.interrupts.ignore", ignore)
    with pytest.raises(SystemExit) as left:
        cli.main(["--version"])
    assert (left.value.code, capsys.readouterr().err) == (
        130,
        "jkr: error: interrupted; nothing half-written was left\n",
    )


def test_the_exit_code_is_told() -> None:
    assert f"{interrupts.CODE} interrupted (Ctrl-C)" in (cli.jkr.help or "")
