"""Series files changed from outside: by a program that seals them again, or by one that does not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py

from jkrcli.base import hdf5
from jkrcli.base.errors import InputError


def edit(path: Path, change: Callable[[h5py.File], object]) -> None:
    """Change the file and seal it again, as another program that follows the format would."""
    with h5py.File(path, "r+") as file:
        change(file)
    try:
        root = hdf5.tree_of(path, path.read_bytes())
    except InputError:
        return  # nothing to seal: it cannot be read at all
    with h5py.File(path, "r+") as file:
        for name, part in root.members.items():
            if isinstance(part, hdf5.Group) and hdf5.SEAL in part.attributes:
                file[name].attrs[hdf5.SEAL] = hdf5.digest(part)
        file.attrs[hdf5.SEAL] = hdf5.digest(root)
