"""``jkr doctor``: what of jkr works on this machine."""

from __future__ import annotations

from dataclasses import asdict

import click

from .. import __version__
from .machine import examine
from .output import answer, json_option

MARKS = {"ok": "ok      ", "optional": "optional", "missing": "MISSING "}


@click.command()
@json_option
def doctor(as_json: bool) -> int:
    """Look at versions, the mesher's system libraries, optional parts, threads, memory and temporary files.

    Exit code 0 where everything required works, 1 where something is missing; each line says what to type.

    \b
    jkr doctor
    """
    findings = examine()
    sound = all(finding.state != "missing" for finding in findings)
    if as_json:
        answer({"jkr": __version__, "sound": sound, "findings": [asdict(f) for f in findings]})
        return int(not sound)
    click.echo(f"jkr {__version__}")
    for finding in findings:
        remedy = f"; type: {finding.remedy}" if finding.remedy else ""
        click.echo(f"  {MARKS[finding.state]}  {finding.part:<16} {finding.found}{remedy}")
    return int(not sound)
