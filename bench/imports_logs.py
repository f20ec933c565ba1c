"""Logs of autopilots and MATLAB files: Tumble against the libraries that read them, on the same files in the same run.

usage: imports_logs.py PROGRAM [--rounds N] [--output FILE.md]

PROGRAM is build/release/bench/bench_log_reader. Each reader runs in a fresh process in turn, and times the reading
alone, page cache warm. Tumble reads as users read, with the SHA-256 of the file in a second thread. Sums of all samples are
compared. Needs numpy, scipy, pyulog and pymavlink.
"""

import argparse
import os
import platform
import statistics
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

ULOG = """
import sys, time, pyulog, numpy
wall, cpu = time.perf_counter(), time.process_time()
log = pyulog.ULog(sys.argv[1], ["sensor_gyro", "sensor_accel"])
print(time.perf_counter() - wall, time.process_time() - cpu, end=" ")
fields = [d.data[f].astype(float) for d in log.data_list for f in ("x", "y", "z", "temperature")]
print(len(fields[0]), sum(f.sum() for f in fields) + 273.15 * sum(len(d.data["x"]) for d in log.data_list))
"""
DATAFLASH = """
import sys, time, numpy
from pymavlink import mavutil
wall, cpu = time.perf_counter(), time.process_time()
log, rows = mavutil.mavlink_connection(sys.argv[1]), []
while (m := log.recv_match(type="IMU")) is not None:
    rows.append((m.TimeUS, m.GyrX, m.GyrY, m.GyrZ, m.AccX, m.AccY, m.AccZ, m.T))
data = numpy.array(rows)
print(time.perf_counter() - wall, time.process_time() - cpu, end=" ")
print(len(data), data[:, 1:].sum() + 273.15 * len(data))
"""
MATLAB = """
import sys, time, scipy.io, numpy
wall, cpu = time.perf_counter(), time.process_time()
read = scipy.io.loadmat(sys.argv[1])
data = [read[f"c{i}"].ravel() for i in range(6)]
print(time.perf_counter() - wall, time.process_time() - cpu, end=" ")
print(len(data[0]), sum(d.sum() for d in data))
"""


def message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def make_ulog(path, count):
    """Two topics of `count` messages, as PX4 writes them."""
    import numpy
    fields = ("uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;float temperature;"
              "uint32_t error_count;uint8_t[3] clip_counter;uint8_t samples;")
    out = b"ULog\x01\x12\x35\x01" + bytes(8) + message("B", bytes(40))
    names = ("sensor_gyro", "sensor_accel")
    out += b"".join(message("F", f"{name}:{fields}".encode()) for name in names)
    out += b"".join(message("A", struct.pack("<BH", 0, k) + name.encode()) for k, name in enumerate(names))
    row = [("size", "<u2"), ("type", "u1"), ("id", "<u2"), ("t", "<u8"), ("s", "<u8"), ("device", "<u4"), ("v", "<f4", 4),
           ("errors", "<u4"), ("rest", "u1", 4)]
    random = numpy.random.default_rng(7)
    data = numpy.zeros((count, 2), dtype=row)
    data["size"], data["type"] = numpy.dtype(row).itemsize - 3, ord("D")
    data["id"] = [0, 1]
    stamps = 1000000 + 1000 * numpy.arange(count) + random.integers(0, 60, count)
    data["t"], data["s"] = stamps[:, None] + 100, stamps[:, None]
    data["v"] = random.integers(-500, 500, (count, 2, 4)) * 0.0625
    path.write_bytes(out + data.tobytes())


def make_dataflash(path, count):
    import numpy
    fmt = lambda number, length, name, types, labels: b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, length, name, types, labels)
    out = fmt(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    row = [("head", "u1", 3), ("t", "<u8"), ("i", "u1"), ("v", "<f4", 6), ("e", "<u4", 2), ("T", "<f4"), ("h", "u1", 2), ("r", "<u2", 2)]
    out += fmt(140, numpy.dtype(row).itemsize, b"IMU", b"QBffffffIIfBBHH",
               b"TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz")
    random = numpy.random.default_rng(8)
    data = numpy.zeros(count, dtype=row)
    data["head"] = [0xa3, 0x95, 140]
    data["t"] = 1000000 + 1000 * numpy.arange(count) + random.integers(0, 60, count)
    data["v"] = random.integers(-500, 500, (count, 6)) * 0.0625
    data["T"] = 30 + random.integers(0, 100, count) * 0.0625
    path.write_bytes(out + data.tobytes())


def make_matlab(path, count, compressed):
    """Counts of 16 bits times a scale: what packs as real samples do, about five to one."""
    import numpy
    import scipy.io
    random = numpy.random.default_rng(9)
    columns = {f"c{i}": (20 * random.standard_normal(count)).round() * 2.0 ** -10 for i in range(6)}
    scipy.io.savemat(path, {**columns, "fs": 400.0}, do_compression=compressed, oned_as="column")


def run(command):
    return [float(word) for word in subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()]


def processor():
    for line in open("/proc/cpuinfo"):
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return platform.processor()


def compare(program, name, path, peer, code, arguments, rounds):
    """A row of the table; medians over the rounds."""
    import math
    ours, theirs = [], []
    for _ in range(rounds):
        theirs.append(run([sys.executable, "-c", code, path]))
        ours.append(run([program, path, *arguments]))
    assert ours[0][2] == theirs[0][2] and math.isclose(ours[0][3], theirs[0][3], rel_tol=1e-9), (name, ours[0], theirs[0])
    size = os.path.getsize(path) / 1e6
    median = lambda rows, i: statistics.median(row[i] for row in rows)
    return (f"| {name} | {size:.0f} | {peer} | {median(theirs, 0):.3f} | {median(ours, 0):.3f} | {median(ours, 1):.3f} | "
            f"{size / median(ours, 0):.0f} | {median(theirs, 0) / median(ours, 0):.1f} | {median(theirs, 1) / median(ours, 1):.1f} |")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--count", type=int, default=1000000)
    parser.add_argument("--output")
    options = parser.parse_args()
    before = os.getloadavg()[0]
    columns = ["-"] + [f"c{i}" for i in range(6)]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        make_ulog(folder / "a.ulg", options.count)
        rows.append(compare(options.program, "ULog, 2 topics", str(folder / "a.ulg"), "pyulog, both topics", ULOG, [], options.rounds))
        make_dataflash(folder / "a.bin", options.count)
        rows.append(compare(options.program, "DataFlash, IMU", str(folder / "a.bin"), "pymavlink mavutil", DATAFLASH, [],
                            options.rounds))
        for compressed in (False, True):
            make_matlab(folder / "a.mat", 22 * options.count // 5, compressed)
            rows.append(compare(options.program, f"MAT v5{', packed' if compressed else ''}, 6 columns", str(folder / "a.mat"),
                                "scipy.io.loadmat", MATLAB, columns, 2 * options.rounds + 1))
    lines = ["# Logs of autopilots and MATLAB files", "",
             f"{options.count} messages a topic, 6 x {22 * options.count // 5} numbers. {options.rounds} rounds (MATLAB: "
             f"{2 * options.rounds + 1}), each reader in a fresh process in turn, page cache warm; medians. Load of the machine: "
             f"{before:.1f} at the beginning, {os.getloadavg()[0]:.1f} at the end, on {os.cpu_count()} processors.", "",
             "| file | MB | peer | peer, wall [s] | Tumble, wall [s] | processor [s] | MB/s, wall | peer / Tumble, wall | processor |",
             "|---|---|---|---|---|---|---|---|---|", *rows, "",
             "Tumble: channels in SI and stamps in s, with the SHA-256 of the file in a second thread, whose time is part of the "
             "processor time. Numbers of samples and sums agree.", "", processor() + "; " +
             subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout.splitlines()[0] +
             f"; Python {platform.python_version()}"]
    for library in ("numpy", "scipy", "pyulog", "pymavlink"):
        from importlib.metadata import version
        lines[-1] += f", {library} {version(library)}"
    text = "\n".join(lines) + ".\n"
    print(text)
    if options.output:
        Path(options.output).write_text(text)


if __name__ == "__main__":
    main()
