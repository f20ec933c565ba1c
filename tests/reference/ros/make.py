#!/usr/bin/env python3
"""Writes the logs of this folder with the reference libraries, and expected.csv with the numbers that they hold.

usage: make.py     in an environment with rosbags 0.11.9, mcap 1.6.0, mcap-ros2-support 0.6.0, numpy
"""

import shutil
import tempfile
from pathlib import Path

import numpy
from mcap.writer import CompressionType, IndexType, Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Writer2
from rosbags.typesys import Stores, get_typestore

FOLDER = Path(__file__).resolve().parent
BEGIN = 1403636579758555392  # ns; the first stamp of EuRoC MH_01
COUNT, STEP = 60, 5_000_000  # messages, ns: 200 Hz
IMU_DEFINITION = """std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


def numbers():
    """One row a message: angular rate [rad/s], specific force [m/s^2]."""
    random = numpy.random.default_rng(18)
    return random.normal([0.01, -0.02, 0.03, 0.1, -0.2, 9.81], 0.05, (COUNT, 6))


def messages(store, ros1):
    """(topic, type, time, message) in the order of time: an IMU, a magnetometer, a thermometer, and a text."""
    types = store.types
    extra = {"seq": 0} if ros1 else {}

    def header(time):
        stamp = types["builtin_interfaces/msg/Time"](time // 10**9, time % 10**9)
        return types["std_msgs/msg/Header"](stamp=stamp, frame_id="imu_link", **extra)

    vector, zeros = types["geometry_msgs/msg/Vector3"], numpy.zeros(9)
    for i, row in enumerate(numbers()):
        time = BEGIN + i * STEP
        late = time + 400_000 + 1000 * (i % 7)  # the recorder is later than header.stamp
        yield "/imu/data", "sensor_msgs/msg/Imu", late, types["sensor_msgs/msg/Imu"](
            header(time), types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0), zeros, vector(*row[:3]), zeros,
            vector(*row[3:]), zeros)
        if i % 2 == 0:
            yield "/imu/mag", "sensor_msgs/msg/MagneticField", late + 10, types["sensor_msgs/msg/MagneticField"](
                header(time), vector(1e-6 * i, 2e-5, -4e-5), zeros)
        if i % 20 == 0:
            yield "/imu/temperature", "sensor_msgs/msg/Temperature", late + 20, types["sensor_msgs/msg/Temperature"](
                header(time), 25.0 + 0.5 * i, 0.0)
            yield "/status", "std_msgs/msg/String", late + 30, types["std_msgs/msg/String"]("ready")


def bag1(name, packing=None):
    store = get_typestore(Stores.ROS1_NOETIC)
    (FOLDER / name).unlink(missing_ok=True)
    writer = Writer1(FOLDER / name)
    writer.chunk_threshold = 8192
    if packing:
        writer.set_compression(packing)
    with writer:
        connections = {}
        for topic, kind, time, message in messages(store, True):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], time, store.serialize_ros1(message, kind))


def two_imus(name):
    """Two IMUs of 20 messages each."""
    store = get_typestore(Stores.ROS1_NOETIC)
    (FOLDER / name).unlink(missing_ok=True)
    with Writer1(FOLDER / name) as writer:
        connections = {topic: writer.add_connection(topic, "sensor_msgs/msg/Imu", typestore=store)
                       for topic in ("/imu/data", "/imu/data_raw")}
        for topic, kind, time, message in list(messages(store, True))[:40]:
            if topic == "/imu/data":
                for connection in connections.values():
                    writer.write(connection, time, store.serialize_ros1(message, kind))


def bag2(name, packed_messages=False):
    store = get_typestore(Stores.ROS2_HUMBLE)
    with tempfile.TemporaryDirectory() as folder:
        writer = Writer2(f"{folder}/bag", version=8, storage_plugin=StoragePlugin.SQLITE3)
        if packed_messages:
            writer.set_compression(CompressionMode.MESSAGE, CompressionFormat.ZSTD)
        with writer:
            connections = {}
            for topic, kind, time, message in messages(store, False):
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=store)
                writer.write(connections[topic], time, store.serialize_cdr(message, kind))
        shutil.copy(f"{folder}/bag/bag.db3", FOLDER / name)


def split(name, storage):
    """A bag of two files; in the second one other numbers belong to the topics."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    everything = list(messages(store, False))
    target = FOLDER / name
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir()
    for number, part in [(9, everything[:60]), (10, everything[60:])]:
        with tempfile.TemporaryDirectory() as folder:
            with Writer2(f"{folder}/bag", version=8, storage_plugin=storage) as writer:
                kinds = sorted({(topic, kind) for topic, kind, _, _ in part}, reverse=number == 10)
                connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds}
                for topic, kind, time, message in part:
                    writer.write(connections[topic], time, store.serialize_cdr(message, kind))
            (written,) = (path for path in Path(f"{folder}/bag").iterdir() if path.suffix != ".yaml")
            shutil.copy(written, target / f"{name}_{number}{written.suffix}")
            shutil.copy(f"{folder}/bag/metadata.yaml", target / "metadata.yaml")


def mcap(name, compression, ros1=False, **settings):
    """ROS 2 messages as CDR, or ROS 1 messages; by the mcap library alone, which leaves the bytes as they are."""
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    with open(FOLDER / name, "wb") as file:
        writer = McapWriter(file, chunk_size=8192, compression=compression, **settings)
        writer.start(profile="ros1" if ros1 else "ros2")
        channels = {}
        for topic, kind, time, message in messages(store, ros1):
            if topic not in channels:
                shown = kind.replace("/msg/", "/") if ros1 else kind
                schema = writer.register_schema(shown, "ros1msg" if ros1 else "ros2msg",
                                                store.generate_msgdef(kind, ros_version=1 if ros1 else 2)[0].encode())
                channels[topic] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schema)
            data = store.serialize_ros1(message, kind) if ros1 else store.serialize_cdr(message, kind)
            writer.add_message(channels[topic], time, bytes(data), time)
        writer.finish()


def mcap_ros2(name):
    """An IMU alone, by mcap-ros2-support."""
    def vector(values):
        return dict(zip("xyz", map(float, values)))

    with open(FOLDER / name, "wb") as file:
        writer = Ros2McapWriter(file)
        schema = writer.register_msgdef("sensor_msgs/msg/Imu", IMU_DEFINITION)
        for i, row in enumerate(numbers()):
            time = BEGIN + i * STEP
            writer.write_message("/imu/data", schema, {
                "header": {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": "imu_link"},
                "orientation": {**vector([0, 0, 0]), "w": 1.0}, "orientation_covariance": [0.0] * 9,
                "angular_velocity": vector(row[:3]), "angular_velocity_covariance": [0.0] * 9,
                "linear_acceleration": vector(row[3:]), "linear_acceleration_covariance": [0.0] * 9}, time, time)
        writer.finish()


def main():
    bag1("plain.bag")
    bag1("lz4.bag", Writer1.CompressionFormat.LZ4)
    bag1("bz2.bag", Writer1.CompressionFormat.BZ2)
    two_imus("two_imus.bag")
    bag2("plain.db3")
    bag2("packed_messages.db3", packed_messages=True)
    mcap("plain.mcap", CompressionType.NONE)
    mcap("lz4.mcap", CompressionType.LZ4)
    mcap("zstd.mcap", CompressionType.ZSTD)
    mcap("ros1.mcap", CompressionType.ZSTD, ros1=True)
    mcap("unchunked.mcap", CompressionType.NONE, use_chunking=False)
    mcap("no_index.mcap", CompressionType.LZ4, index_types=IndexType.NONE, repeat_channels=False, repeat_schemas=False,
         use_statistics=False, use_summary_offsets=False)
    mcap_ros2("ros2_writer.mcap")
    split("split_db3", StoragePlugin.SQLITE3)
    split("split_mcap", StoragePlugin.MCAP)
    for name, source in [("imu.bag", "lz4.bag"), ("imu.mcap", "zstd.mcap")]:
        shutil.copy(FOLDER / source, FOLDER.parents[2] / "examples/data" / name)
    rows = ["gyro.x,gyro.y,gyro.z,accelerometer.x,accelerometer.y,accelerometer.z"]
    rows += [",".join(repr(float(value)) for value in row) for row in numbers()]
    (FOLDER / "expected.csv").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
