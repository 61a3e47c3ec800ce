"""The process as the program ``jkr``: settings that nobody wants who imports jkrcli into a program of his own."""

import atexit
import gc

RARELY = (1_000_000, 10, 10)  # containers made between two looks for cycles; choice: saves an eighth for 1 MB
_begun: list[bool] = []


def begin() -> None:
    """Commands are short: no time goes into what only long processes, or people at a prompt, have something of."""
    gc.set_threshold(*RARELY)
    atexit.register(gc.freeze)  # else all is searched for cycles once more at the end: a quarter of a command's time
    _begun.append(True)


def runs() -> bool:
    """Whether this process is the program."""
    return bool(_begun)
