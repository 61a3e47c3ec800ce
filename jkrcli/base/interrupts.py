"""Ctrl-C: one line and exit code 130 at any moment, from the first import to the end of the process."""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False  # typing's own is not worth its time here
if TYPE_CHECKING:
    from types import FrameType

SAID = "interrupted; nothing half-written was left"
CODE = 130  # 128 + SIGINT, as shells count
HAS_MASKS = hasattr(signal, "pthread_sigmask")  # not on Windows
_came = False  # a KeyboardInterrupt was raised
_waits = False  # none is raised now


def _leave(*_: object) -> None:
    try:
        os.write(2, f"jkr: error: {SAID}\n".encode())
    finally:
        os._exit(CODE)


def leave_at_once() -> None:
    """While modules are imported Ctrl-C ends the process on the spot: nothing is written yet, and libraries may take
    the exception for a fault of their own. Where it is ignored (nohup) it stays ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)


def raise_from_here() -> None:
    """From here on Ctrl-C is a KeyboardInterrupt, so that work is given up in order."""
    if signal.getsignal(signal.SIGINT) is _leave:
        import threading  # noqa: F401 - for ``_once_more``, which may come while anything is imported

        sys.unraisablehook = _if_lost
        signal.signal(signal.SIGINT, _raise)


def _raise(_: int, frame: FrameType | None) -> None:
    """A KeyboardInterrupt; while a module is imported only once that is done: compiled ones, and libraries that can do
    without one, make a failed import of it."""
    global _came
    if _waits:
        return _once_more()
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return _once_more()
        frame = frame.f_back
    _came = True
    raise KeyboardInterrupt


class Waiting:
    """A block in which Ctrl-C waits for its end; processes that are started there inherit that it is blocked."""

    def __enter__(self) -> None:
        global _waits
        _waits = True
        if HAS_MASKS:
            self._before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})

    def __exit__(self, *_: object) -> None:
        global _waits
        _waits = False
        if HAS_MASKS:
            signal.pthread_sigmask(signal.SIG_SETMASK, self._before)


def came() -> bool:
    """Whether a KeyboardInterrupt was raised: other errors behind it are its consequence, compiled code makes such."""
    return _came


def _if_lost(lost: sys.UnraisableHookArgs) -> None:
    """A Ctrl-C that met a destructor or a callback, from which Python lets nothing out, is sent anew, out of there."""
    if lost.exc_type is KeyboardInterrupt:
        _once_more()
    else:
        sys.__unraisablehook__(lost)


def _once_more() -> None:
    from threading import Timer

    # os.kill wakes the main thread too, be it in a library; on Windows it ends the process
    sent = (os.kill, (os.getpid(), signal.SIGINT)) if HAS_MASKS else (signal.raise_signal, (signal.SIGINT,))
    timer = Timer(0.01, *sent)
    timer.daemon = True  # a process that ends meanwhile is not held up
    timer.start()


def ignore() -> None:
    """All is done and said; the process only ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
