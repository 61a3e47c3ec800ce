"""Small files as the programs of force microscopes write them: the same record of approach and retraction in each."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

ROWS = 40  # of each segment
K, SENSITIVITY = 0.05, 6e-8  # N/m, m/V
GRID = np.concatenate([np.linspace(0, 1, ROWS), np.linspace(1, 0, ROWS)])
HEIGHT = 3e-6 - 2e-6 * GRID  # m, grows away from the specimen
FORCE = 4e-9 * np.maximum(GRID - 0.4, 0) ** 1.5 - 2e-10 * (np.arange(2 * ROWS) > 1.4 * ROWS) * (GRID > 0.3)  # N


# ---------------------------------------------------------------------- JPK: a zip of properties and whole numbers
def jpk_members(curves: int = 0) -> dict[str, bytes]:
    """The members of a .jpk-force, or of a .jpk-force-map of so many ``curves``."""
    names = [f"index/{i}/" for i in range(curves)] or [""]
    general = {"jpk-data-file": "spm-forcefile"}
    if curves:
        grid = {"ilength": curves, "jlength": 1, "xcenter": 0, "ycenter": 0, "ulength": 1e-6 * curves, "vlength": 1e-6}
        general = {f"force-scan-map.position-pattern.grid.{key}": value for key, value in grid.items()}
    members = {"header.properties": properties(general), "shared-data/": b"", "index/" if curves else "segments/": b""}
    members["shared-data/header.properties"] = properties(shared_data())
    for number, name in enumerate(names):
        at = {"position-index": number, "position.x": 1e-6 * (number - curves / 2 + 0.5), "position.y": 0}
        header = {f"force-scan-map.header.{key}": value for key, value in at.items()} if curves else {}
        members |= {name: b""} if name else {}
        members[f"{name}header.properties"] = properties({**general, **header} if not curves else header)
        members[f"{name}segments/"] = b""
        for segment, style in enumerate(("extend", "retract")):
            members |= _segment(f"{name}segments/{segment}/", segment, style, number)
    return members


def _segment(folder: str, segment: int, style: str, number: int) -> dict[str, bytes]:
    rows = slice(segment * ROWS, (segment + 1) * ROWS)
    settings = {"duration": 0.4, "z-start": 2e-6, "z-end": 0, "setpoint": 0.5}
    told: dict[str, object] = {f"settings.segment-settings.{key}": value for key, value in settings.items()}
    told |= {"settings.style": style, "settings.feedback-mode.name": "contact"}
    told |= {"duration": 0.4, "num-points": ROWS, "approach-id": "a1", "time-stamp": r"2020-03-12 14\:21\:05 UTC"}
    header = {f"force-segment-header.{key}": value for key, value in told.items()}
    header |= {"force-scan-map.header.position-index": number}
    header |= {f"channel.{name}.lcd-info.*": i for i, name in enumerate(CHANNELS)}
    channels = {
        f"{folder}channels/{name}.dat": np.round((values[rows] - offset) / factor).astype(">i4").tobytes()
        for name, (values, offset, factor, _) in CHANNELS.items()
    }
    return {
        folder: b"",
        f"{folder}segment-header.properties": properties(header),
        f"{folder}channels/": b"",
        **channels,
    }


# readings, offset and factor of their whole numbers, and how they become metres and newtons: slot, base, factor, unit
CHANNELS: dict[str, tuple[Any, float, float, list[tuple[str, str, float, str]]]] = {
    "vDeflection": (FORCE / K / SENSITIVITY, 0.01, 1e-9,
                    [("distance", "volts", SENSITIVITY, "m"), ("force", "distance", K, "N")]),
    "height": (1.1 * HEIGHT, 0, 1e-14, [("nominal", "volts", 1, "m"), ("calibrated", "nominal", 1, "m")]),
    "measuredHeight": (HEIGHT, 0, 1e-14, [("nominal", "volts", 1, "m")]),
}  # fmt: skip


def shared_data() -> dict[str, object]:
    """What the channels of all segments have in common."""
    found: dict[str, object] = {}
    for i, (_, offset, factor, slots) in enumerate(CHANNELS.values()):
        told: dict[str, object] = {"encoder.type": "signedinteger", "encoder.scaling.offset": offset}
        told |= {"encoder.scaling.multiplier": factor, "conversion-set.conversions.base": "volts"}
        for slot, base, size, unit in slots:
            held = {"name": slot, "base-calibration-slot": base, "scaling.offset": 0.0}
            held |= {"scaling.multiplier": size, "scaling.unit.unit": unit}
            told |= {f"conversion-set.conversion.{slot}.{key}": value for key, value in held.items()}
        found |= {f"lcd-info.{i}.{key}": value for key, value in told.items()}
    return found


def properties(told: Mapping[str, object]) -> bytes:
    return "".join(f"{key}={value}\n" for key, value in told.items()).encode()


def zipped(path: Path, members: Mapping[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in members.items():
            file.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)
    return path


# ---------------------------------------------------------------------- others
def ibw(path: Path) -> Path:
    """A binary wave of Igor, version 5, as Asylum's microscopes write it."""
    data = np.column_stack([-1.1 * HEIGHT, FORCE / K, -HEIGHT]).astype("<f4")
    told = {"Wave": 1, "ImagingMode": "Contact", "NumPtsPerSec": 100, "InvOLS": SENSITIVITY, "TriggerChannel": "Force",
            "TriggerPoint": 1e-9, "SpringConstant": K, "InputTime": 0.8, "ApproachVelocity": 5e-6,
            "RetractVelocity": 5e-6, "MicroscopeModel": "MFP3D", "Version": "1", "Date": "2020-03-12",
            "Time": "2:21:05 PM"}  # fmt: skip
    note = "".join(f"{key}: {value}\r" for key, value in told.items()).encode()
    labels = b"".join(word.ljust(32, b"\0") for word in (b"", b"Raw", b"Defl", b"ZSnsr"))
    values = data.tobytes(order="F")
    wave = struct.pack("<LLLlhh6xh32slL", 0, 0, 0, data.size, 2, 0, 1, b"wave", 0, 0)
    wave += struct.pack("<4l", *data.shape, 0, 0) + struct.pack("<8d", *[1.0] * 4, *[0.0] * 4)
    wave = wave.ljust(320, b"\0")
    sizes = [320 + len(values), 0, len(note), 0, 0, 0, 0, 0, 0, len(labels), 0, 0, 0, 0, 0]
    head = struct.pack("<hh15l", 5, 0, *sizes) + wave
    checksum = -sum(struct.unpack("<192h", head)) & 0xFFFF
    path.write_bytes(head[:2] + checksum.to_bytes(2, "little") + head[4:] + values + note + labels)
    return path


def workshop(path: Path, point: int = 1, mode: str = "Single") -> Path:
    """A table of AFM Workshop."""
    path.write_bytes(workshop_text(point, mode).encode())
    return path


def workshop_text(point: int = 1, mode: str = "Single") -> str:
    head = ["Force-Distance Curve", "File Format:\t3", "", "Date:\tWednesday, August 1, 2018", "Time:\t1:07:47 PM",
            f"Mode:\t{mode}", f"Point:\t{point}", f"X, um:\t{(point - 1) % 2}.25", f"Y, um:\t{(point - 1) // 2}.25", "",
            f"Force Constant, nN/nm:\t{K}", f"Light Lever Gain, mV/nm:\t{1e-6 / SENSITIVITY}",
            "Extend Z-Sense(nm),Extend T-B(V),Retract Z-Sense(nm),Retract T-B(V)"]  # fmt: skip
    z, volts = -1e9 * HEIGHT, FORCE / K / SENSITIVITY
    rows = np.column_stack([z[:ROWS], volts[:ROWS], z[ROWS:], volts[ROWS:]])
    return "\n".join([*head, *(",".join(f"{cell:.6f}" for cell in row) for row in rows)]) + "\n"


def workshop_map(path: Path, curves: int = 4) -> Path:
    """A zip of such tables."""
    return zipped(path, {f"{i}.csv": workshop_text(i, "Mapping").encode() for i in range(1, curves + 1)})


def ntmdt(path: Path) -> Path:
    """An export of NT-MDT: height and the deflections of both directions, no names."""
    current = FORCE / K / SENSITIVITY * 1e9
    rows = zip(1e9 * HEIGHT[:ROWS], current[:ROWS], current[ROWS:][::-1], strict=True)
    path.write_text("".join("\t".join(f"{cell:.6f}" for cell in row) + "\n" for row in rows), encoding="ascii")
    return path


def chiaro(path: Path) -> Path:
    """A table of an Optics11 Chiaro."""
    told = [("Date", "12/03/2020"), ("Time", "14:21:05"), ("k (N/m)", K), ("Max load (µN)", 1), ("Software version", 1),
            ("Piezo position (nm) (Measured)", 2000), ("Piezo speed  (µm/s)", 5), ("Device:", "Chiaro")]  # fmt: skip
    head = [*(f"{key}\t{value}" for key, value in told), "", "Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)"
            "\tPiezo (nm)"]  # fmt: skip
    time = np.linspace(0, 1, 2 * ROWS)
    rows = np.column_stack([time, 1e6 * FORCE, -1e9 * (HEIGHT + FORCE / K), 1e9 * FORCE / K, -1e9 * HEIGHT])
    text = "\n".join([*head, *("\t".join(f"{cell:.6f}" for cell in row) for row in rows)]) + "\n"
    path.write_bytes(text.encode("latin-1"))
    return path


def exported(path: Path, curves: int = 1) -> Path:
    """A .tab or .h5 as afmformats itself exports them."""
    import afmformats
    import h5py

    columns = {"force": FORCE, "height (measured)": HEIGHT, "height (piezo)": 1.1 * HEIGHT,
               "time": np.linspace(0, 1, 2 * ROWS), "segment": np.repeat([0, 1], ROWS)}  # fmt: skip
    told = {"imaging mode": "force-distance", "path": path.name, "spring constant": K, "point count": 2 * ROWS}
    sets = [afmformats.AFMForceDistance(columns, told | {"enum": i}) for i in range(curves)]
    if path.suffix == ".tab":
        sets[0].export_data(path)
        return path
    with h5py.File(path, "w") as file:
        for one in sets:
            one.export_data(file, fmt="hdf5")
    return path


KINDS: dict[str, Callable[[Path], Path]] = {
    "jpk": lambda folder: zipped(folder / "one.jpk-force", jpk_members()),
    "jpk map": lambda folder: zipped(folder / "map.jpk-force-map", jpk_members(3)),
    "ibw": lambda folder: ibw(folder / "one.ibw"),
    "tab": lambda folder: exported(folder / "one.tab"),
    "hdf5": lambda folder: exported(folder / "map.h5", 2),
    "workshop": lambda folder: workshop(folder / "workshop.csv"),
    "workshop map": lambda folder: workshop_map(folder / "map.zip"),
    "ntmdt": lambda folder: ntmdt(folder / "ntmdt.txt"),
    "chiaro": lambda folder: chiaro(folder / "chiaro.txt"),
}  # a file of each format in a folder
