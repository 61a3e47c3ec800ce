"""Series files changed from outside: by a program that seals them again, or by one that does not."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError

CASE = """
title = "plain"
method = "closed-form"
indenter = { shape = "paraboloid", radius = "1 mm" }
specimen.half_space = { E = "1 MPa", nu = 0.3 }
loading = { radius = "0.1 mm", points = 20 }
adhesion = { w = "50 mJ/m^2" }
"""


def edit(path: Path, change: Callable[[h5py.File], object]) -> None:
    """Change the file and seal it again, as another program that follows the format would: texts have a length."""
    with h5py.File(path, "r+") as file:
        change(file)
        _fix(file)
        file.visititems(lambda _, item: _fix(item))
    try:
        root = hdf5.tree_of(path, path.read_bytes())
    except InputError:
        return  # nothing to seal: it cannot be read at all
    with h5py.File(path, "r+") as file:
        for name, part in root.members.items():
            if isinstance(part, hdf5.Group) and hdf5.SEAL in part.attributes:
                file[name].attrs[hdf5.SEAL] = np.bytes_(hdf5.digest(part))
        file.attrs[hdf5.SEAL] = np.bytes_(hdf5.digest(root))


def one_byte_changed(path: Path, trials: int, read: Callable[[], object]) -> int:
    """How many of so many single random changes are refused in one line that names the file; ``read`` asserts that the
    others changed nothing."""
    whole, rng, refused = path.read_bytes(), np.random.default_rng(3), list[tuple[str, ...]]()
    for place in rng.integers(0, len(whole), trials):
        damaged = bytearray(whole)
        damaged[place] ^= int(rng.integers(1, 256))
        path.write_bytes(damaged)
        try:
            read()
        except InputError as error:
            refused.append(error.lines)
    assert all(len(lines) == 1 for lines in refused), refused
    path.write_bytes(whole)
    return len(refused)


def lengthened(path: Path, rows: int) -> None:
    """The series with so many ``rows``, interpolated."""

    def lengthen(file: h5py.File) -> None:
        for group in ("series", "errors"):
            for name, data in list(file[group].items()):
                values = np.interp(np.linspace(0, 1, rows), np.linspace(0, 1, data.size), data[()])
                attributes = dict(data.attrs)
                del file[group][name]
                file[group].create_dataset(name, data=values).attrs.update(attributes)

    edit(path, lengthen)


def _fix(item: h5py.Group | h5py.Dataset) -> None:
    """Give texts the length that our files give them."""
    for name in item.attrs:
        if h5py.check_string_dtype(item.attrs.get_id(name).dtype) and isinstance(value := item.attrs[name], str):
            item.attrs[name] = hdf5._fixed(value)
    for name in list(item) if isinstance(item, h5py.Group) else ():
        one = item.get(name) if item.get(name, getlink=True).__class__ is h5py.HardLink else None
        kind = h5py.check_string_dtype(one.dtype) if isinstance(one, h5py.Dataset) else None
        if kind is not None and kind.length is None and one.shape == ():
            text = one.asstr()[()]
            del item[name]
            item[name] = hdf5._fixed(text)
