"""The process as the program ``jkr``: settings that nobody wants who imports jkrcli into a program of his own."""

import atexit
import gc
import os
import sys

RARELY = (1_000_000, 10, 10)  # containers made between two looks for cycles; choice: saves an eighth for 1 MB
_begun: list[bool] = []


def begin() -> None:
    """Streams that were closed are there; and, as commands are short, no time goes into what only long processes, or
    people at a prompt, have something of."""
    _open_streams()
    if not sys.argv[0].endswith("__main__.py"):  # of python -m, which may find this package in the folder at hand
        os.environ["PYTHONSAFEPATH"] = "1"  # processes that are started here take no modules from there either
    gc.set_threshold(*RARELY)
    atexit.register(gc.freeze)  # else all is searched for cycles once more at the end: a quarter of a command's time
    _begun.append(True)


def _open_streams() -> None:
    """Open stdin, stdout and stderr to nothing where the caller closed them: else the next file that is opened gets the
    number of one, and what a library prints goes into it."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # it takes the lowest number that is free
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115, PTH123 - to the end


def runs() -> bool:
    """Whether this process is the program."""
    return bool(_begun)
