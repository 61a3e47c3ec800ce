"""``python -m jkrcli`` is the command ``jkr``."""

from .cli import main

main()
