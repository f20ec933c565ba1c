#!/usr/bin/env python3
"""Logs of ROS 1, ROS 2 and MCAP: reading against rosbags and mcap, and `tumble identify allan_noise` from file to result.

usage: imports_ros.py PROGRAM READER [--messages N] [--peer-messages N] [--rounds N] [--output FILE.md]

PROGRAM is build/release/tumble, READER build/release/bench/bench_log_reader. The log has sensor_msgs/Imu at 400 Hz: 11 000 s, and for
the libraries, whose time grows with the number of messages, a shorter one. Rate and acceleration are counts of a converter of 16 bits
with white noise, covariances are zero. Files are in the page cache. Needs numpy, rosbags, mcap, mcap-ros2-support, zstandard.
"""

import argparse
import os
import sqlite3
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from identify import PUBLISHED_WALL, machine, measure_one  # noqa: E402

BEGIN, STEP, TOPIC, FRAME = 1403636579758555392, 2_500_000, b"/imu/data", b"imu_link"
PER_CHUNK = 2048
ROSBAGS = """
import sys, time
from pathlib import Path
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
wall, cpu = time.perf_counter(), time.process_time()
total, count = 0.0, 0
with AnyReader([Path(sys.argv[1])], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
    for connection, stamp, raw in reader.messages():
        message = reader.deserialize(raw, connection.msgtype)
        w, a = message.angular_velocity, message.linear_acceleration
        total += w.x + w.y + w.z + a.x + a.y + a.z
        count += 1
print(time.perf_counter() - wall, time.process_time() - cpu, count, total)
"""
MCAP = """
import sys, time
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
wall, cpu = time.perf_counter(), time.process_time()
total, count = 0.0, 0
with open(sys.argv[1], "rb") as file:
    for _, _, _, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
        w, a = message.angular_velocity, message.linear_acceleration
        total += w.x + w.y + w.z + a.x + a.y + a.z
        count += 1
print(time.perf_counter() - wall, time.process_time() - cpu, count, total)
"""


def bodies(first, count, ros1, random):
    """Serialised messages as rows of bytes."""
    k = numpy.arange(first, first + count)
    stamps = BEGIN + k * STEP
    if ros1:
        kind = numpy.dtype([("seq", "<u4"), ("sec", "<u4"), ("nsec", "<u4"), ("length", "<u4"), ("frame", "S8"), ("x", "<f8", 37)])
    else:
        kind = numpy.dtype([("cdr", "<u4"), ("sec", "<i4"), ("nsec", "<u4"), ("length", "<u4"), ("frame", "S8"), ("pad", "<u4"), ("x", "<f8", 37)])
    rows = numpy.zeros(count, kind)
    rows["sec"], rows["nsec"], rows["frame"] = stamps // 10**9, stamps % 10**9, FRAME
    if ros1:
        rows["seq"], rows["length"] = k, len(FRAME)
    else:
        rows["cdr"], rows["length"] = 0x100, len(FRAME) + 1
    counts = numpy.round(random.normal(0, 20, (count, 6)))
    rows["x"][:, 3] = 1.0
    rows["x"][:, 13:16] = counts[:, :3] * (numpy.pi / 180 / 131.0)
    rows["x"][:, 25:28] = counts[:, 3:] * (9.80665 / 16384) + [0, 0, 9.8]
    return stamps + 300_000, rows.view(numpy.uint8).reshape(count, -1)


def framed(head, data):
    """Rows of a header and a body, one after the other."""
    return numpy.hstack([head.view(numpy.uint8).reshape(len(head), -1), data]).tobytes()


def field(name, value):
    return struct.pack("<I", len(name) + 1 + len(value)) + name + b"=" + value


def record(fields, data):
    header = b"".join(field(name, value) for name, value in fields)
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def ros_time(stamp):
    return struct.pack("<II", stamp // 10**9, stamp % 10**9)


def write_bag(path, messages):
    definition = [(b"topic", TOPIC), (b"type", b"sensor_msgs/Imu"), (b"md5sum", b"6a62c6daae103f4ff57a132d6f95cec2"),
                  (b"message_definition", IMU_DEFINITION)]
    connection = record([(b"op", b"\7"), (b"conn", bytes(4)), (b"topic", TOPIC)], b"".join(field(*entry) for entry in definition))
    fixed = struct.pack("<I", 38) + field(b"op", b"\2") + field(b"conn", bytes(4)) + struct.pack("<I", 13) + b"time="
    kind = numpy.dtype([("fixed", "u1", len(fixed)), ("time", "<u4", 2), ("data", "<u4")])
    random, infos = numpy.random.default_rng(3), []
    with open(path, "wb") as file:
        def head(index, chunks):
            file.seek(0)
            fields = [(b"op", b"\3"), (b"index_pos", struct.pack("<Q", index)), (b"conn_count", struct.pack("<I", 1)),
                      (b"chunk_count", struct.pack("<I", chunks))]
            length = sum(len(field(*entry)) for entry in fields)
            file.write(b"#ROSBAG V2.0\n" + record(fields, b" " * (4096 - 8 - length)))

        head(0, 0)
        for first in range(0, messages, PER_CHUNK):
            times, data = bodies(first, min(PER_CHUNK, messages - first), True, random)
            rows = numpy.zeros(len(data), kind)
            rows["fixed"] = numpy.frombuffer(fixed, numpy.uint8)
            rows["time"][:, 0], rows["time"][:, 1], rows["data"] = times // 10**9, times % 10**9, data.shape[1]
            content = (connection if first == 0 else b"") + framed(rows, data)
            offset = len(content) - len(rows) * (kind.itemsize + data.shape[1])
            infos.append((file.tell(), times[0], times[-1], len(data)))
            file.write(record([(b"op", b"\5"), (b"compression", b"none"), (b"size", struct.pack("<I", len(content)))], content))
            index = numpy.zeros(len(rows), numpy.dtype([("time", "<u4", 2), ("offset", "<u4")]))
            index["time"], index["offset"] = rows["time"], offset + numpy.arange(len(rows)) * (kind.itemsize + data.shape[1])
            file.write(record([(b"op", b"\4"), (b"ver", struct.pack("<I", 1)), (b"conn", bytes(4)),
                               (b"count", struct.pack("<I", len(rows)))], index.tobytes()))
        end = file.tell()
        file.write(connection)
        for place, begin, last, count in infos:
            file.write(record([(b"op", b"\6"), (b"ver", struct.pack("<I", 1)), (b"chunk_pos", struct.pack("<Q", place)),
                               (b"start_time", ros_time(begin)), (b"end_time", ros_time(last)), (b"count", struct.pack("<I", 1))],
                              struct.pack("<II", 0, count)))
        head(end, len(infos))


def write_mcap(path, messages, packing):
    """As the mcap library writes it, with index and summary."""
    import zlib

    import zstandard

    def text(value):
        return struct.pack("<I", len(value)) + value

    def put(op, data):
        return bytes([op]) + struct.pack("<Q", len(data)) + data

    schema = put(3, struct.pack("<H", 1) + text(b"sensor_msgs/msg/Imu") + text(b"ros2msg") + text(IMU_DEFINITION_2))
    channel = put(4, struct.pack("<HH", 0, 1) + text(TOPIC) + text(b"cdr") + struct.pack("<I", 0))
    kind = numpy.dtype([("op", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log", "<u8"), ("publish", "<u8")])
    random, chunks = numpy.random.default_rng(3), []
    compress = zstandard.ZstdCompressor().compress if packing == b"zstd" else bytes
    magic = b"\x89MCAP0\r\n"
    with open(path, "wb") as file:
        file.write(magic + put(1, text(b"ros2") + text(b"bench")))
        for first in range(0, messages, PER_CHUNK):
            times, data = bodies(first, min(PER_CHUNK, messages - first), False, random)
            rows = numpy.zeros(len(data), kind)
            rows["op"], rows["length"], rows["log"], rows["publish"] = 5, kind.itemsize - 9 + data.shape[1], times, times
            rows["sequence"] = numpy.arange(first, first + len(rows))
            content = (schema + channel if first == 0 else b"") + framed(rows, data)
            offset = len(content) - len(rows) * (kind.itemsize + data.shape[1])
            packed = compress(content)
            begin, span = file.tell(), struct.pack("<QQ", int(times[0]), int(times[-1]))
            file.write(put(6, span + struct.pack("<QI", len(content), zlib.crc32(content)) + text(packing)
                           + struct.pack("<Q", len(packed)) + packed))
            length, index_begin = file.tell() - begin, file.tell()
            index = numpy.stack([times, offset + numpy.arange(len(rows)) * (kind.itemsize + data.shape[1])], 1).astype("<u8").tobytes()
            file.write(put(7, struct.pack("<HI", 0, len(index)) + index))
            chunks.append(put(8, span + struct.pack("<QQIHQ", begin, length, 10, 0, index_begin)
                              + struct.pack("<Q", file.tell() - index_begin) + text(packing)
                              + struct.pack("<QQ", len(packed), len(content))))
        file.write(put(15, struct.pack("<I", 0)))
        summary = file.tell()
        file.write(schema + channel + b"".join(chunks))
        file.write(put(11, struct.pack("<QHIIIIQQ", messages, 1, 1, 0, 0, len(chunks), BEGIN, BEGIN + messages * STEP)
                       + struct.pack("<IHQ", 10, 0, messages)))
        file.write(put(2, struct.pack("<QQI", summary, 0, 0)) + magic)


def write_db3(path, messages):
    """rosbags writes a bag of one message, which is then filled."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore
    folder = Path(path).with_suffix("")
    with Writer(folder, version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connection = writer.add_connection(TOPIC.decode(), "sensor_msgs/msg/Imu", typestore=get_typestore(Stores.ROS2_HUMBLE))
        times, data = bodies(0, 1, False, numpy.random.default_rng(3))
        writer.write(connection, int(times[0]), data.tobytes())
    database, random = sqlite3.connect(folder / f"{folder.name}.db3"), numpy.random.default_rng(3)
    database.execute("PRAGMA journal_mode=OFF")
    database.execute("PRAGMA synchronous=OFF")
    topic, = database.execute("SELECT id FROM topics").fetchone()
    database.execute("DELETE FROM messages")
    for first in range(0, messages, PER_CHUNK):
        times, data = bodies(first, min(PER_CHUNK, messages - first), False, random)
        database.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                             zip([topic] * len(data), times.tolist(), (row.tobytes() for row in data)))
    database.commit()
    database.close()
    (folder / "metadata.yaml").write_text((folder / "metadata.yaml").read_text().replace(
        "message_count: 1", f"message_count: {messages}"))
    return folder


def imu_definitions():
    from rosbags.typesys import Stores, get_typestore
    return [get_typestore(store).generate_msgdef("sensor_msgs/msg/Imu", ros_version=version)[0].encode()
            for store, version in [(Stores.ROS1_NOETIC, 1), (Stores.ROS2_HUMBLE, 2)]]


IMU_DEFINITION, IMU_DEFINITION_2 = imu_definitions()
FORMATS = {"ROS 1 bag": ("a.bag", 50), "MCAP": ("a.mcap", 50), "MCAP, zstd": ("z.mcap", 25), "ROS 2 db3": ("d/d.db3", 25)}


def write_all(folder, messages):
    write_bag(folder / "a.bag", messages)
    write_mcap(folder / "a.mcap", messages, b"")
    write_mcap(folder / "z.mcap", messages, b"zstd")
    write_db3(folder / "d.db3", messages)


def run(command):
    words = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    return [float(word) for word in words]


def warm(path):
    with open(path, "rb") as file:
        while file.read(1 << 24):
            pass


def least_times(path):
    """Processor seconds of one thread: SHA-256 of a file in blocks of 256 kB as Tumble takes it, and the copy alone."""
    import hashlib
    times = []
    for hashing in (True, False):
        best = float("inf")
        for _ in range(3):
            digest, begin, block = hashlib.sha256(), time.process_time(), bytearray(1 << 18)
            with open(path, "rb", buffering=0) as file:
                while count := file.readinto(block):
                    if hashing:
                        digest.update(memoryview(block)[:count])
            best = min(best, time.process_time() - begin)
        times.append(best)
    return times


def arithmetic(large, processor):
    """What the hash leaves of the time wanted: processor [s] of `tumble identify` of the bag."""
    hashing, copying = least_times(large / "a.bag")
    rest = processor - hashing
    return [f"The hash is worked out by a thread of its own beside the reading. SHA-256 of the bag takes one processor {hashing:.2f} s here, of "
            f"which {copying:.2f} s are the copy out of the page cache; its steps depend on each other, so no second processor helps. The "
            f"other {rest:.2f} s of processor time (a second copy, decoding, pages that the kernel clears, checks, six analyses) run beside "
            f"it. On two processors the result cannot be there before {max(hashing, processor / 2):.2f} s."]


def reading(options, large, small):
    """Rows of the table of reading: seconds per million messages."""
    rows = []

    def per_million(runs, column):
        return statistics.median(row[column] for row in runs) / runs[0][2] * 1e6

    for name, (file, wanted) in FORMATS.items():
        warm(large / file), warm(small / file)
        whole, ours, theirs, others = [], [], [], []
        for _ in range(options.rounds):
            whole.append(run([options.reader, large / file]))
            ours.append(run([options.reader, "--stream", large / file]))
            theirs.append(run([sys.executable, "-c", ROSBAGS, small / file if not file.startswith("d/") else small / "d"]))
            if "MCAP" in name:
                others.append(run([sys.executable, "-c", MCAP, small / file]))
        for way in ([], ["--stream"]):
            small_sum = run([options.reader, *way, small / file])
            assert small_sum[2] == theirs[0][2] == options.peer_messages, name
            assert abs(small_sum[3] / theirs[0][3] - 1) < 1e-9, name
        wall, peer = per_million(ours, 0), per_million(theirs, 0)
        other = f"{per_million(others, 0):.1f}" if others else ""
        rows.append(f"| {name} | {os.path.getsize(large / file) / 1e6:.0f} | {wall:.3f} | {per_million(ours, 1):.3f} "
                    f"| {per_million(whole, 0):.3f} | {per_million(whole, 1):.3f} | {peer:.2f} | {other} | {peer / wall:.0f} | {wanted} |")
    return rows


def identification(options, large):
    """Rows of the table of whole runs, and the processor time [s] of the first file."""
    rows, processor = [], 0.0
    for name, (file, _) in FORMATS.items():
        warm(large / file)
        command = [options.program, "identify", "allan_noise", str(large / file), "-o", str(large / "result.json")]
        runs = [measure_one(command) for _ in range(2 * options.rounds)]
        wall, cpu, memory = zip(*runs)
        limit = {"ROS 1 bag": "1.0", "MCAP, zstd": "1.9"}.get(name, "")
        processor = processor if rows else statistics.median(cpu)
        rows.append(f"| {name} | {statistics.median(wall):.2f} | {min(wall):.2f} | {max(wall):.2f} | {statistics.median(cpu):.2f} "
                    f"| {max(memory):.0f} | {limit} |")
    return rows, processor


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("reader")
    parser.add_argument("--messages", type=int, default=4_400_000)
    parser.add_argument("--peer-messages", type=int, default=200_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--folder", type=Path, help="keeps the files there")
    parser.add_argument("--output")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = options.folder or Path(scratch)
        large, small = folder / "large", folder / "small"
        for place, count in [(large, options.messages), (small, options.peer_messages)]:
            if not place.exists():
                place.mkdir(parents=True)
                write_all(place, count)
        header = machine()
        whole, processor = identification(options, large)
        floor = arithmetic(large, processor)
        table = reading(options, large, small)
    load = os.getloadavg()[0]
    lines = ["# Logs of ROS", "", header + f" Load after the runs {load:.1f}.",
             f"{options.messages} messages of sensor_msgs/Imu ({options.messages / 400:.0f} s at 400 Hz), files in the page cache, "
             f"{options.rounds} rounds, medians. Written by `bench/imports_ros.py`.", "",
             "## Reading", "", "Seconds for 10^6 messages. Block after block: the messages are decoded into channels, summed and let go, as the loop of the "
             "libraries does. Into memory: as `tumble identify` reads, all samples and stamps are kept, while one processor "
             "computes the SHA-256 (decision 092), which is not waited for. rosbags (`AnyReader`, `deserialize`) and mcap with mcap-ros2-support "
             f"read a file of {options.peer_messages} messages in the same run. The sums of all values agree.", "",
             "| file | MB | block after block, wall | processor | into memory, wall | processor | rosbags | mcap "
             "| rosbags / block after block | wanted |",
             "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|", *table, "",
             "## `tumble identify allan_noise`, file to result", "",
             "Whole processes: the six channels are read, hashed, checked and analysed, and the result is written.", "",
             "| file | wall median [s] | min | max | processor [s] | peak memory [MB] | wanted [s] |",
             "|---|---:|---:|---:|---:|---:|---:|", *whole, "", *floor, "",
             f"Published for a bag of this shape (allan_variance_analyzer, on its author's machine): {PUBLISHED_WALL} s."]
    text = "\n".join(lines) + "\n"
    print(text)
    if options.output:
        Path(options.output).write_text(text)


if __name__ == "__main__":
    main()
