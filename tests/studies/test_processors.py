"""Other arithmetic for the fast tests: what a machine has of it, and that it is really at work."""

import subprocess
from dataclasses import replace

import pytest

from jkrcli.base.errors import SolveError
from studies import processors
from studies.processors import Arithmetic, Setting, arithmetic, settings

NEW = Arithmetic(
    ("SSE3", "AVX2", "AVX512_SKX", "X86_V3", "X86_V4"), ("X86_V3", "X86_V4"), ("SkylakeX", "SkylakeX"), (2, 2)
)


def test_settings_are_those_that_the_machine_has() -> None:
    assert [setting.name for setting in settings(NEW)] == ["Haswell", "oldest", "plain", "Prescott", "threads"]
    older = replace(NEW, features=("SSE3", "AVX2", "X86_V3"), kernels=("Haswell", "Haswell"))
    assert [setting.name for setting in settings(older)] == ["oldest", "plain", "Prescott", "threads"]
    zen = replace(older, kernels=("Zen", "Zen"))  # its kernels are those of Haswell
    assert [setting.name for setting in settings(zen)] == ["oldest", "plain", "Prescott", "threads"]
    assert [setting.name for setting in settings(Arithmetic((), ("ASIMDHP",), (), ()))] == ["threads"]
    laptop, oldest, *_ = settings(NEW)
    assert laptop.environment(NEW) == {"OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": "1"}
    assert oldest.environment(NEW) == {
        "OPENBLAS_CORETYPE": "Prescott", "OPENBLAS_NUM_THREADS": "8", "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4"
    }  # fmt: skip


def test_this_machine_takes_on_the_first_of_its_settings() -> None:
    own = arithmetic({})
    setting = next(settings(own))
    found = arithmetic(setting.environment(own))
    setting.check(found)
    assert len(found.kernels) in (0, 2), "NumPy's and SciPy's own"
    with pytest.raises(SolveError, match=setting.name):
        setting.check(replace(own, threads=(0, 0)))


def test_a_failure_under_one_of_them_is_told(study, monkeypatch: pytest.MonkeyPatch) -> None:
    """The fast tests are run for each; here they fail under the first."""
    runs = []

    def run(words: list[str], env: dict[str, str], check: bool) -> subprocess.CompletedProcess[str]:
        runs.append((words[words.index("-m", 3) :], env["OPENBLAS_NUM_THREADS"]))
        return subprocess.CompletedProcess(words, int(len(runs) == 1))

    monkeypatch.setattr(processors, "arithmetic", lambda _: NEW)
    monkeypatch.setattr(Setting, "check", lambda *_: None)
    monkeypatch.setattr(subprocess, "run", run)
    done = study("processors", "--most", "2", "tests/methods")
    assert runs == [(["-m", "not slow", "tests/methods"], "1"), (["-m", "not slow", "tests/methods"], "8")]
    assert done.code == 1
    assert [line.split(" | ")[-1] for line in done.out.splitlines()[-2:]] == ["FAILED |", "passed |"]
