"""Ctrl-C: one line and exit code 130 at any moment, from the first import to the end of the process."""

from __future__ import annotations

import os
import signal
import sys

SAID = "interrupted; nothing half-written was left"
CODE = 130  # 128 + SIGINT, as shells count


def _leave(*_: object) -> None:
    os.write(2, f"jkr: error: {SAID}\n".encode())
    os._exit(CODE)


def leave_at_once() -> None:
    """While modules are imported Ctrl-C ends the process on the spot: nothing is written yet, and libraries may take
    the exception for a fault of their own. Where it is ignored (nohup) it stays ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)


def raise_from_here() -> None:
    """From here on Ctrl-C is a KeyboardInterrupt, so that work is given up in order."""
    if signal.getsignal(signal.SIGINT) is _leave:
        sys.unraisablehook = _once_more
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _once_more(lost: sys.UnraisableHookArgs) -> None:
    """A Ctrl-C that met a destructor or a callback, from which Python lets nothing out, is sent anew, out of there."""
    if lost.exc_type is KeyboardInterrupt:
        from threading import Timer

        Timer(0.01, os.kill, (os.getpid(), signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(lost)


def ignore() -> None:
    """All is done and said; the process only ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
