"""Small files as the programs of force microscopes write them: the same record of approach and retraction in each."""

import struct
import zipfile
from collections.abc import Callable, Mapping
from functools import partial
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
def ibw(
    path: Path, pixel: tuple[int, int] | None = None, marks: Mapping[str, str] | None = None,
    record: tuple[np.ndarray, np.ndarray] = (HEIGHT, FORCE),
) -> Path:  # fmt: skip
    """A binary wave of Igor, version 5, as Asylum's microscopes write it; ``pixel``: column and row in a map; ``marks``
    of its segments; ``record``: heights and forces."""
    height, force = record
    data = np.column_stack([-1.1 * height, force / K, -height]).astype("<f4")
    told = {"Wave": 1, "ImagingMode": "Contact", "NumPtsPerSec": 100, "InvOLS": SENSITIVITY, "TriggerChannel": "Force",
            "TriggerPoint": 1e-9, "SpringConstant": K, "InputTime": 0.8, "ApproachVelocity": 5e-6,
            "RetractVelocity": 5e-6, "MicroscopeModel": "MFP3D", "Version": "1", "Date": "2020-03-12",
            "Time": "2:21:05 PM", **(marks or {})}  # fmt: skip
    if pixel is not None:
        told |= {"XLVDT": f"{1e-6 * pixel[0]:g}", "YLVDT": f"{1e-6 * pixel[1]:g}"}
        told |= {"FMapLineCounter": pixel[1], "FMapPointCounter": pixel[0]}
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


# ---------------------------------------------------------------------- Nanosurf
def nanosurf(path: Path, side: int = 1, unit: str = "V", record: Any = None, **changed: Any) -> Path:
    """A .nhf of version 2 as Nanosurf's reader reads it, of one curve or of a square map: advance, a wait and retract,
    numbers of four bytes. ``record``: height [m], force [N] and times [s] of both ways instead of those of all files;
    ``changed``: attributes of the measurement or "channel.attribute", of which None leaves one out."""
    import h5py

    height, force, time = (HEIGHT, FORCE, TIME) if record is None else record
    half, per_unit = height.size // 2, {"V": K * SENSITIVITY, "m": K, "N": 1.0}[unit]
    told: dict[str, Any] = {"group_type": "spectroscopy", "measurement_name": "Spec Grid 1",
            "spm_probe_calibration_spring_constant": K, "rect_axis_size": [side, side],
            "spm_probe_calibration_deflection_sensitivity": SENSITIVITY}  # fmt: skip
    columns = {"Deflection": (force / per_unit, f"Unit ({unit})"), "Position Z": (height, "m"), "Time": (time, "s")}
    with h5py.File(path, "w") as file:
        file.attrs.update({key: changed.pop(key, 2 - i) for i, key in enumerate(
            ("nsf_file_version_major", "nsf_file_version_minor"))})  # fmt: skip
        file.create_group("group_0001").attrs["group_type"] = "calibration"
        measurement = file.create_group("group_0000")
        entries = {key: value for key, value in (told | changed).items() if "." not in key and value is not None}
        measurement.attrs.update(entries)
        measurement["dataset_0000"] = np.zeros(side**2)
        for number, (title, rows) in enumerate((("Advance to Setpoint 1", slice(0, half)), ("Wait 1", slice(0, 0)),
                                                ("Retract 1", slice(half, None)))):  # fmt: skip
            segment = measurement.create_group(f"subgroup_{number:04d}")
            segment.attrs["segment_name"] = title
            for at, (name, (values, spelled)) in enumerate(columns.items()):
                least, most = values.min() - 1e-12, values.max() + 1e-12
                counts = np.round((values[rows] - least) / (most - least) * 2 * SURF_MOST) - SURF_MOST
                data = segment.create_dataset(f"dataset_{2 * at:04d}", data=np.tile(counts, side**2).astype("i4"))
                of_channel = {
                    "signal_name": name, "signal_calibration_unit": spelled, "signal_calibration_min": least,
                    "signal_calibration_max": most, "signal_minmax": [-SURF_MOST, SURF_MOST],
                    "dataset_block_size_source": f"b{at}", "signal_data_pattern": "snake_bottom_left",
                }  # fmt: skip
                of_channel |= {key.split(".")[1]: one for key, one in changed.items() if key.split(".")[0] == name}
                data.attrs.update({key: one for key, one in of_channel.items() if one is not None})
                sizes = segment.create_dataset(f"dataset_{2 * at + 1:04d}", data=np.full(side**2, counts.size))
                sizes.attrs["dataset_block_size_id"] = f"b{at}"
    return path


SURF_MOST = 2**31 - 1  # of the numbers that stand for a range


# ---------------------------------------------------------------------- Bruker's Nanoscope
def nanoscope(
    path: Path, curves: int = 1, capture: bool = False, least: int = 0, columns: int = 2, image: int = 0, **changed: str
) -> Path:
    """A binary file: of one curve with a height sensor in two bytes, of a map over a ramp in four, shifted by one, or
    a ``capture`` of PeakForce. ``least``: rows of each direction beside those that are filled; ``columns`` of a map and
    pixels of a line of its ``image``, if that has others. ``changed``: lines of the head."""
    size, shift = (2, 1) if curves == 1 else (4, 256)
    stride = ROWS + least
    z = 1e-6 - HEIGHT if not capture else 1e-7 * np.cos(2 * np.pi * (np.arange(2 * ROWS) - ROWS) / (2 * ROWS))
    channels = {"DeflectionError": (FORCE / K / SENSITIVITY, "DeflSens")}
    if curves == 1 and not capture:
        channels["ZSensor"] = (z / 1e-6, "ZsensSens")
    blocks = []
    for values, _ in channels.values():
        counts = np.full((2, stride), 77)
        counts[:, :ROWS] = shift * np.round(np.stack([values[:ROWS][::-1], values[ROWS:]]) / PER_COUNT)
        blocks.append(np.tile(counts.ravel(), curves).astype(f"<i{size}").tobytes())
    scan = {"Operating mode": "Force" if curves == 1 else "Force Volume", "Samps/line": str(image or columns),
            "Lines": str(curves // columns * (image or columns) // columns),
            "Scan Size": "2000 nm", "PeakForce Capture": "Allow" if capture else "Never", "Peak Force Amplitude": "100",
            "PFT Freq": "2 KHz", "Sample Points": str(4 * ROWS), "Sync Distance QNM": str(2 * ROWS),
            "@Sens. DeflSens": f"V {SENSITIVITY * 1e9:g} " + "nm/V" * (curves == 1), "@Sens. Zsens": "V 10.00000 nm/V",
            "@Sens. ZsensSens": "V 1000.000 nm/V"}  # fmt: skip
    if capture:
        scan |= {"Samps/line": "1", "Lines": "1"}
    force = {"Forward vel.": "200", "Reverse vel.": "200", "Samps/line, retrace": str(ROWS)}
    force |= {"force/line": f"{columns} 0"} if image else {}
    sections = [("Force file list", {"Version": "0x09200000"}), ("Ciao scan list", scan), ("Ciao force list", force)]
    start = 6000
    for (name, (_, sens)), block in zip(channels.items(), blocks, strict=True):
        told = {"Data offset": str(start), "Data length": str(len(block)), "Bytes/pixel": "2",
                "Samps/line": f"{stride} {ROWS}", "Spring Constant": str(K), "@4:Image Data": f'S [{name}] "{name}"',
                "@4:Z scale": f"V [Sens. {sens}] ({PER_COUNT} V/LSB) 3.5 V",
                "@4:Ramp size": "V [Sens. Zsens] (0.006713867 V/LSB) 200.0000 V"}  # fmt: skip
        sections.append(("Ciao force image list", told))
        start += len(block)
    lines = [line for name, told in sections for line in (f"\\*{name}", *(
        f"\\{key}: {changed.get(key, text)}" for key, text in told.items()))]  # fmt: skip
    head = "\r\n".join([*lines, "\\*File list end", "\x1a"]).encode("cp1252")
    path.write_bytes(head.ljust(6000, b"\0") + b"".join(blocks))
    return path


PER_COUNT = 0.000375  # V


# ---------------------------------------------------------------------- exports in text, by the makers' layouts
def export(path: Path, maker: str) -> Path:
    """The record as the program of a ``maker`` exports it."""
    head, columns, rows = EXPORTS[maker]
    mark, decimal = MARKS.get(maker, ("\t", "."))
    body = [mark.join(f"{cell:.9g}".replace(".", decimal) for cell in row) for row in rows]
    parts = head(body[:ROWS], body[ROWS:]) if callable(head) else [*head, columns, *body]
    path.write_bytes(("\r\n".join(parts) + "\r\n").encode("cp1252"))
    return path


TIME = np.linspace(0, 1, 2 * ROWS)
Z = 3e-6 - HEIGHT  # toward the specimen
MARKS = {"instron": (",", "."), "zwick": (";", ","), "zhn": ("\t", ","), "jpk": (" ", ".")}


def _jpk_text(approach: list[str], retract: list[str]) -> list[str]:
    """The retraction as JPK writes it, its last row first, and the time of each segment begins anew."""
    names = ["# columns: height vDeflection seriesTime time", "# units: m N s s", f"# springConstant: {K}", "#"]
    return ["# direction: trace", *names, *approach, "", "# direction: retrace", *names, *retract[::-1]]


_SIDES = np.column_stack([TIME[:ROWS], TIME[:ROWS], 1e9 * HEIGHT[:ROWS][::-1], 1e9 * HEIGHT[ROWS:],
                          (FORCE / K / SENSITIVITY)[:ROWS][::-1], (FORCE / K / SENSITIVITY)[ROWS:],
                          1e12 * FORCE[:ROWS][::-1], 1e12 * FORCE[ROWS:]])  # fmt: skip
_TITLES = "Time_s_Ex\tTime_s_Rt\tHeight_Sensor_nm_Ex\tHeight_Sensor_nm_Rt\tDefl_V_Ex\tDefl_V_Rt\tDefl_pN_Ex\tDefl_pN_Rt"
_HEAD = ["\\*Force file list", f"\\@Sens. DeflSens: V {SENSITIVITY * 1e9:.5f} nm/V", f"\\Spring Constant: {K}",
         "\\*File list end"]  # fmt: skip
EXPORTS: dict[str, tuple[Any, str, np.ndarray]] = {
    "nanoscope": ([f'"{line}"' for line in _HEAD], _TITLES + "\tDefl_V_Ex\tDefl_V_Rt",
                  np.column_stack([_SIDES, _SIDES[:, 4:6]])),
    "nanoscope volts": (_HEAD, "\t".join(_TITLES.split("\t")[2:6]), _SIDES[:, 2:6]),
    "jpk": (_jpk_text, "", np.column_stack([HEIGHT, FORCE, TIME, np.tile(TIME[:ROWS], 2)])),
    "optics11": (["Tip radius (um)\t48.5", f"k (N/m)\t{K}", "Calibration factor\t2.5", ""],
                 "Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary", np.column_stack(
        [TIME, 1e6 * FORCE, 1e9 * (Z - FORCE / K), 1e9 * FORCE / K, 1e9 * Z, 0 * TIME])),
    "hysitron": (["", f"Number of Points = {2 * ROWS}", ""], "Depth (nm)\tLoad (µN)\tTime (s)\tDepth (V)\tLoad (V)",
                 np.column_stack([1e9 * (Z - FORCE / K), 1e6 * FORCE, TIME, 1e6 * Z, 1e9 * FORCE])),
    "zhn": (["Eindringkörper: Kugel 50 µm", ""], "Zeit\tEindringtiefe\tNormalkraft\r\ns\tµm\tmN",
            np.column_stack([TIME, 1e6 * (Z - FORCE / K), 1e3 * FORCE])),
    "instron": ([], '"Time","Compressive extension","Load"\r\n"(s)","(mm)","(N)"',
                np.column_stack([TIME, 1e3 * Z, FORCE])),
    "zwick": ([], '"Prüfzeit";"Standardweg";"Standardkraft"\r\n"s";"mm";"N"', np.column_stack([TIME, 1e3 * Z, FORCE])),
}  # fmt: skip


def _exported(maker: str, folder: Path) -> Path:
    return export(folder / f"{maker}.txt", maker)


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
    "nanoscope": lambda folder: nanoscope(folder / "one.000"),
    "nanoscope map": lambda folder: nanoscope(folder / "map.spm", 4),
    "nanoscope capture": lambda folder: nanoscope(folder / "one.pfc", capture=True),
    "nanosurf": lambda folder: nanosurf(folder / "map.nhf", 2),
    **{f"{maker} in text": partial(_exported, maker) for maker in EXPORTS},
}  # a file of each format in a folder
