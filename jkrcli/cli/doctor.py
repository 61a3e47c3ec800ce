"""``jkr doctor``: what of jkr works on this machine."""

from __future__ import annotations

from ..report.machine import Machine
from .options import json_option
from .verb import verb
from .voice import give


@verb()
@json_option
def doctor(as_json: bool) -> int:
    """Look at versions, the mesher's system libraries, optional parts, threads, memory and temporary files.

    Exit code 0 where everything required works, 1 where something is missing; each line says what to type.

    \b
    jkr doctor
    """
    machine = Machine.examined()
    give(machine, as_json)
    return int(not machine.is_sound)
