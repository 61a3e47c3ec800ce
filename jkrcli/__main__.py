"""``jkr``, and ``python -m jkrcli``."""

import contextlib
import os
import signal
import sys
from types import FrameType


def main() -> None:
    """Entry point of ``jkr``."""
    met: list[int] = []  # Ctrl-C: what is being imported then may fail with any error, not only KeyboardInterrupt

    def interrupt(number: int, _: FrameType | None) -> None:
        met.append(number)
        raise KeyboardInterrupt

    try:
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # not where the caller ignores it
            signal.signal(signal.SIGINT, interrupt)
        from .base import process

        process.begin()
        from .cli import INTERRUPTED
        from .cli import main as command

        code = command()
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done: Python may clear up
    except BaseException:
        if not met:
            raise
        os.write(2, b"jkr: error: interrupted; nothing half-written was left\n")
        os._exit(130)
    if code == INTERRUPTED:  # modules that were loaded by half may not survive the clearing up
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.flush()
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    main()
