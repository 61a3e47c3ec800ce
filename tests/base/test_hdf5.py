"""Values of HDF5 files whose types are of other widths than NumPy's: the library converts them."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from jkrcli.base import hdf5


def wide_truth() -> Any:
    """Truth values of eight bytes, which NumPy holds in one."""
    kind = h5py.h5t.enum_create(h5py.h5t.STD_I64LE)
    kind.enum_insert(b"FALSE", 0)
    kind.enum_insert(b"TRUE", 1)
    return kind


def short_float() -> Any:
    """The first two bytes of a float of four, which NumPy holds in four."""
    kind = h5py.h5t.IEEE_F32LE.copy()
    kind.set_fields(15, 7, 8, 0, 7)
    kind.set_size(2)
    return kind


@pytest.mark.parametrize("kind", [wide_truth, short_float, lambda: h5py.h5t.IEEE_F64BE, lambda: h5py.h5t.STD_U16BE])
def test_numbers_of_any_width(tmp_path: Path, kind: Any) -> None:
    with h5py.File(tmp_path / "others.h5", "w") as file:
        numbers = np.array([1, 0, 1, 1], dtype=kind().dtype)
        held, space = h5py.h5t.py_create(numbers.dtype), h5py.h5s.create_simple(numbers.shape)
        h5py.h5d.create(file.id, b"values", kind(), space).write(h5py.h5s.ALL, h5py.h5s.ALL, numbers, held)
        h5py.h5a.create(file.id, b"values", kind(), space).write(numbers, held)
    with h5py.File(tmp_path / "others.h5") as file:
        data = file["values"].id
        assert hdf5.values_of(data, data.shape, data.get_type()).tolist() == numbers.tolist()
        assert hdf5.attributes_among(file, ["values"])["values"].tolist() == numbers.tolist()
