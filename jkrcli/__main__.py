"""``jkr``, and ``python -m jkrcli``: Ctrl-C is minded before anything large is imported."""

import os

try:
    from .base.interrupts import leave_at_once
except KeyboardInterrupt:  # these milliseconds too
    os.write(2, b"jkr: error: interrupted; nothing half-written was left\n")  # as base.interrupts says
    os._exit(130)


def main() -> None:
    """Entry point of ``jkr``."""
    leave_at_once()
    from .base import process

    process.begin()
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
