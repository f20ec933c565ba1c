"""Writes the files of this folder by scipy.io.savemat and h5py: needs numpy, scipy, h5py and hdf5storage.

    python3 make.py FOLDER

Sample k of column c of the array number a is a + 0.001 (k + 1) (c + 1), at k / 200 s.
"""

import sys
from pathlib import Path

import h5py
import hdf5storage
import numpy
import scipy.io

N = 60
K = numpy.arange(N)


def block(a, columns):
    return a + 0.001 * (K[:, None] + 1) * (numpy.arange(columns)[None, :] + 1)


def variables():
    return {"t": K / 200, "gyro": block(1, 3), "acc": block(2, 3).T, "temperature": block(3, 1)[:, 0], "note": "unit 0117",
            "bias": numpy.array([1.0, 2.0, 3.0]), "fs": 200.0}


def structure():
    inner = {"t_ms": 5.0 * K, "gyro": block(1, 3), "raw": (100 * block(2, 3)).astype(numpy.int16)}
    trial = numpy.zeros((1, 2), dtype=[("gyro", "O")])
    trial[0, 0]["gyro"], trial[0, 1]["gyro"] = block(5, 1), block(6, 1)
    return {"imu": inner, "trial": trial, "wave": block(1, 1) * 1j, "rate": 100.0}


def hdf5(path):
    """As MATLAB writes version 7.3: 512 bytes before, dimensions reversed, classes as attributes."""
    with h5py.File(path, "w", userblock_size=512) as file:
        def put(at, name, values, kind="double"):
            data = numpy.asarray(values)
            data = numpy.atleast_2d(data).T if data.ndim < 2 else data
            dataset = at.create_dataset(name, data=data.T, compression="gzip" if data.size > 50 else None)
            dataset.attrs["MATLAB_class"] = numpy.bytes_(kind)
        for name, values in variables().items():
            if name == "note":
                put(file, name, numpy.frombuffer(values.encode("utf-16-le"), "<u2")[None, :], "char")
            else:
                put(file, name, values)
        imu = file.create_group("imu")
        imu.attrs["MATLAB_class"] = numpy.bytes_("struct")
        for name, values in structure()["imu"].items():
            put(imu, name, values, "int16" if name == "raw" else "double")
        file.create_group("#refs#")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: never".ljust(116) + bytes(8) + b"\x00\x02IM")


def cells(path):
    """Version 7.3 by hdf5storage: a cell array with a text and a cell within, an array of structures, an object of MATLAB."""
    inside = numpy.empty((1, 1), dtype=object)
    inside[0, 0] = block(4, 1)
    cell = numpy.empty((1, 4), dtype=object)
    cell[0, 0], cell[0, 1], cell[0, 2], cell[0, 3] = block(1, 3), block(2, 3), "unit 0117", inside
    hdf5storage.savemat(str(path), {"run": cell, "trial": structure()["trial"], "fs": 200.0}, format="7.3",
                        store_python_metadata=False)
    with h5py.File(path, "r+") as file:
        table = file.create_dataset("table", data=numpy.array([[3707764736, 2, 1, 1, 1, 1]], dtype=numpy.uint32))
        table.attrs["MATLAB_class"], table.attrs["MATLAB_object_decode"] = numpy.bytes_("table"), numpy.int32(3)


def main(folder):
    folder = Path(folder)
    scipy.io.savemat(folder / "plain.mat", variables(), oned_as="column")
    scipy.io.savemat(folder / "packed.mat", variables(), do_compression=True, oned_as="row")
    scipy.io.savemat(folder / "structure.mat", structure(), do_compression=True)
    scipy.io.savemat(folder / "old.mat", variables(), format="4", oned_as="row")
    scipy.io.savemat(folder / "table.mat", {"data": numpy.column_stack([K / 200, block(1, 3)])}, do_compression=True)
    hdf5(folder / "hdf5.mat")
    cells(folder / "cells.mat")
    read = hdf5storage.loadmat(str(folder / "cells.mat"))
    assert numpy.array_equal(read["run"][0, 1], block(2, 3)) and numpy.array_equal(read["trial"][0, 1]["gyro"], block(6, 1))
    for name in ("plain", "packed", "old"):
        read = scipy.io.loadmat(folder / f"{name}.mat")
        assert numpy.array_equal(read["gyro"], block(1, 3)) and numpy.array_equal(read["acc"], block(2, 3).T), name
    with h5py.File(folder / "hdf5.mat") as read:
        assert numpy.array_equal(read["gyro"][()].T, block(1, 3))
    for path in folder.glob("*.mat"):  # no time of day: the same bytes each time
        content = bytearray(path.read_bytes())
        begin = content[:116].find(b"Created on: ")
        if begin >= 0:
            content[begin:116] = b"Created on: never".ljust(116 - begin)
            path.write_bytes(content)


if __name__ == "__main__":
    main(*sys.argv[1:])
