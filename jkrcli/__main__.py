"""``jkr``, and ``python -m jkrcli``: Ctrl-C is minded before anything large is imported."""

import gc
import os

try:
    from .base.interrupts import leave_at_once
except KeyboardInterrupt:  # these milliseconds too
    os.write(2, b"jkr: error: interrupted; nothing half-written was left\n")  # as base.interrupts says
    os._exit(130)

RARELY = (1_000_000, 10, 10)  # containers made between two looks for cycles; choice: saves 4 to 14 %, costs 12 MB


def main() -> None:
    """Entry point of ``jkr``."""
    leave_at_once()
    gc.set_threshold(*RARELY)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # no other package has a say in how cases are read
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
