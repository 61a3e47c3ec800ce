"""The fast tests as other processors compute: their kernels of OpenBLAS, NumPy without its newer loops, threads.

Sums in another order differ in their last bits. What is right, converges or is refused must not depend on them, so
that a machine tries here what it can of the others' arithmetic.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from jkrcli.base.errors import SolveError

from .command import call

# OpenBLAS's kernels by OPENBLAS_CORETYPE: what they ask of a processor in NumPy's words, and what OpenBLAS calls them,
# first those of the machine's own that are the same
KERNELS = {
    "Haswell": ("AVX2", ("Zen", "Haswell")),
    "Prescott": ("SSE3", ("Katmai",)),
    "SkylakeX": ("AVX512_SKX", ("SkylakeX",)),
}
PROBE = """
import json
import scipy.linalg
import threadpoolctl
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
blas = [pool for pool in threadpoolctl.threadpool_info() if pool["internal_api"] == "openblas"]
kernels, threads = ([pool[key] for pool in blas] for key in ("architecture", "num_threads"))
features = [name for name, has in __cpu_features__.items() if has]
print(json.dumps({"features": features, "loops": __cpu_dispatch__, "kernels": kernels, "threads": threads}))
"""


@dataclass(frozen=True)
class Arithmetic:
    """How a process computes: ``features`` of the processor that NumPy uses, names of its newer ``loops``; kernels and
    threads of NumPy's and SciPy's OpenBLAS, empty where they have another library."""

    features: tuple[str, ...]
    loops: tuple[str, ...]
    kernels: tuple[str, ...]
    threads: tuple[int, ...]

    @property
    def newer(self) -> tuple[str, ...]:
        """The newer loops that are in use."""
        return tuple(name for name in self.loops if name in self.features)


def arithmetic(environment: Mapping[str, str]) -> Arithmetic:
    """How a process with this ``environment`` computes."""
    done = subprocess.run(
        [sys.executable, "-c", PROBE], env=os.environ | environment, capture_output=True, text=True, check=True
    )
    return Arithmetic(**{name: tuple(values) for name, values in json.loads(done.stdout).items()})


@dataclass(frozen=True)
class Setting:
    """Another arithmetic: the ``kernel`` of OpenBLAS, its ``threads``, and whether NumPy is ``plain``; "" and 0 as the
    machine has them."""

    name: str
    kernel: str = ""
    threads: int = 0
    plain: bool = False

    def environment(self, own: Arithmetic) -> dict[str, str]:
        """The variables that bring it about on a machine whose own arithmetic is ``own``."""
        asked = {"OPENBLAS_CORETYPE": self.kernel, "OPENBLAS_NUM_THREADS": str(self.threads or "")}
        asked["NPY_DISABLE_CPU_FEATURES"] = " ".join(own.newer) if self.plain else ""
        return {name: value for name, value in asked.items() if value}

    def check(self, found: Arithmetic) -> None:
        """SolveError where ``found``, the arithmetic of a process with these variables, is not this one."""
        threads = min(self.threads, os.cpu_count() or 1)  # OpenBLAS takes no more
        if self.kernel and not set(found.kernels) <= {KERNELS[self.kernel][1][-1]}:
            raise SolveError(f"{self.name}: OpenBLAS works with kernels of {found.kernels}, not of {self.kernel}")
        if threads and set(found.threads) != {threads}:
            raise SolveError(f"{self.name}: OpenBLAS works with {found.threads} threads, not with {threads}")
        if self.plain and found.newer:
            raise SolveError(f"{self.name}: NumPy still uses {', '.join(found.newer)}")


def settings(own: Arithmetic) -> Iterator[Setting]:
    """The settings that a machine of arithmetic ``own`` has beside it: first that of most laptops, then the most
    different."""
    others = [name for name, (need, same) in KERNELS.items() if need in own.features and not {*own.kernels} & {*same}]
    others = others if own.kernels else []
    laptop = [name for name in others if name == "Haswell"]
    yield from (Setting(kernel, kernel, 1) for kernel in laptop)
    others = [name for name in others if name not in laptop]
    if own.newer:
        yield from (Setting("oldest", kernel, 8, plain=True) for kernel in others[:1])
        yield Setting("plain", threads=1, plain=True)
    yield from (Setting(kernel, kernel, 1) for kernel in others)
    yield Setting("threads", threads=8)


def main(words: Sequence[str] | None = None) -> int:
    """Run the fast tests once for each arithmetic that this machine can take on beside its own, and look first whether
    it has. Prints a table; the exit code is 1 where a test fails under any."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("tests", nargs="*", help="folders or files of tests [default: all]")
    parser.add_argument("--most", type=int, help="so many settings, the most telling first [default: all]")
    given = parser.parse_args(words)
    own, lines, held = arithmetic({}), [], True
    for setting in itertools.islice(settings(own), given.most):
        environment, begin = setting.environment(own), time.monotonic()
        setting.check(found := arithmetic(environment))
        print(setting.name, *(f"{name}='{value}'" for name, value in environment.items()), flush=True)
        tests = [sys.executable, "-m", "pytest", "-n", "auto", "-m", "not slow", *given.tests]
        failed = subprocess.run(tests, env=os.environ | environment, check=False).returncode != 0
        held &= not failed
        loops, outcome = ", ".join(found.newer) or "none", "FAILED" if failed else "passed"
        lines.append(f"| {setting.name} | {', '.join({*found.kernels})} | {max(found.threads, default=1)} | {loops} | "
                     f"{time.monotonic() - begin:.0f} | {outcome} |")  # fmt: skip
    print("| setting | kernels | threads | newer loops | time [s] | tests |\n|---|---|---|---|---|---|")
    print("\n".join(lines))
    return int(not held)


if __name__ == "__main__":
    sys.exit(call(main))
