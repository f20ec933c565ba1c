"""ROS 1 and ROS 2 bags with any message, with rosbags: tumble.read(path, format="rosbags").

IMUs, magnetometers, thermometers and barometers are read by the library itself, many times faster.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tumble._recording import Recording
from tumble._text import need
from tumble.importers import Column, Importer, Request, recording_of

# Field of a message: channel and unit (REP 103: SI).
KNOWN = {
    "sensor_msgs/msg/Imu": {
        **{f"angular_velocity.{axis}": (f"gyro.{axis}", "rad/s") for axis in "xyz"},
        **{f"linear_acceleration.{axis}": (f"accelerometer.{axis}", "m/s^2") for axis in "xyz"},
    },
    "sensor_msgs/msg/Temperature": {"temperature": ("temperature", "degC")},
    "sensor_msgs/msg/MagneticField": {f"magnetic_field.{axis}": (f"magnetometer.{axis}", "T") for axis in "xyz"},
    "sensor_msgs/msg/FluidPressure": {"fluid_pressure": ("pressure", "Pa")},
}


def read(path: str, request: Request) -> Recording:
    """Reads every number of every message, stamped by its header, else by the bag.

    Fields of IMUs, temperatures, magnetometers and pressures get the names and units that Tumble uses; others are
    called `topic.field` and need a unit. Where several topics have messages of one kind, the topic stands before.
    """
    reader_of = need("rosbags.highlevel", "import").AnyReader
    with reader_of([Path(path)]) as reader:
        topics = [connection.topic for connection in reader.connections]
        kinds = [connection.msgtype for connection in reader.connections]
        series: dict[tuple[str, str], list[float]] = {}
        stamps: dict[str, list[float]] = {}
        for connection, time, raw in reader.messages():
            message = reader.deserialize(raw, connection.msgtype)
            stamps.setdefault(connection.topic, []).append(_stamp(message, time))
            for field, value in _numbers(message, ""):
                series.setdefault((connection.topic, field), []).append(value)
    first = min((times[0] for times in stamps.values()), default=0.0)
    kind_of = dict(zip(topics, kinds, strict=True))
    columns, skipped = [], []
    for (topic, field), values in series.items():
        if len(values) != len(stamps[topic]):
            skipped.append(f"{topic}/{field}")
            continue
        name, unit = _named(topic, field, kind_of[topic], kinds.count(kind_of[topic]) > 1)
        if unit is None and request.channels is None and name not in request.units:
            skipped.append(f"{topic}/{field}")
            continue
        times = [stamp - first for stamp in stamps[topic]]
        columns.append(Column(name, unit, f"{topic}/{field}", values, times))
    return recording_of(path, importer.name, columns, request, skipped)


def _stamp(message: Any, nanoseconds: int) -> float:
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return nanoseconds * 1e-9 if stamp is None else stamp.sec + stamp.nanosec * 1e-9


def _numbers(message: Any, prefix: str) -> Iterator[tuple[str, float]]:
    """Numbers of a message by the path of their field; the header is the time."""
    for field in getattr(message, "__dataclass_fields__", ()):
        value = getattr(message, field)
        if field == "header" or field.startswith("__"):
            continue
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            yield prefix + field, float(value)
        elif hasattr(value, "__dataclass_fields__"):
            yield from _numbers(value, f"{prefix}{field}.")


def _named(topic: str, field: str, kind: str, several: bool) -> tuple[str, str | None]:
    name, unit = KNOWN.get(kind, {}).get(field, (None, None))
    place = topic.strip("/").replace("/", ".")
    if name is None:
        return f"{place}.{field}", None
    return (f"{place}.{name}" if several else name), unit


importer = Importer("rosbags", "ROS 1 and ROS 2 bags with any message, with rosbags", (".bag", ".db3", ".mcap"), read)
