"""``jkr``, and ``python -m jkrcli``."""

import os


def main() -> None:
    """Entry point of ``jkr``."""
    try:
        from .base import process

        process.begin()
        from .cli import main as command

        command()
    except KeyboardInterrupt:  # while modules are imported, or behind the last word of a command
        os.write(2, b"jkr: error: interrupted; nothing half-written was left\n")
        os._exit(130)


if __name__ == "__main__":
    main()
