"""``jkr``, and ``python -m jkrcli``: Ctrl-C is minded before anything large is imported."""

from .base.interrupts import leave_at_once


def main() -> None:
    """Entry point of ``jkr``."""
    leave_at_once()
    from .cli import main as command

    command()


if __name__ == "__main__":
    main()
