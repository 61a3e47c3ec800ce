"""What other programs need for the same bodies: timings stored once, made comparable by a yardstick."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from ...base.errors import InputError
from ...base.files import read_bytes
from .chart_measure import Cost
from .chart_reference import Errors

FORMAT, VERSION = "jkr-peers", 1


@dataclass(frozen=True)
class Peer:
    """One run of another program, its costs as on this machine; ``after_imports_cpu_s``: None where not known."""

    name: str
    version: str
    body: str
    settings: str
    unknowns: int
    whole: Cost
    after_imports_cpu_s: float | None
    errors: Errors


def read_peers(path: Path, yardstick: float) -> list[Peer]:
    """The stored runs, their times multiplied by ``yardstick`` [CPU s, of now] over the one of then."""
    try:
        data = json.loads(read_bytes(path, "file of peers"))
        if (data["format"], data["version"]) != (FORMAT, VERSION):
            raise InputError(f"{path}: must be {FORMAT} version {VERSION}, got {data['format']} {data['version']}")
        ratio = yardstick / min(data["yardstick_cpu_s"])
        return [_peer(run, ratio) for run in data["runs"]]
    except (json.JSONDecodeError, KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: is not a file of peers' timings ({error!r})") from None


def _peer(run: dict, ratio: float) -> Peer:
    after = run["after_imports_cpu_s"]
    return Peer(
        run["peer"],
        run["version"],
        run["body"],
        run["settings"],
        run["unknowns"],
        Cost(run["cpu_s"] * ratio, run["wall_s"] * ratio, run["memory_mib"]),
        None if after is None else after * ratio,
        Errors(**run["errors"]),
    )
