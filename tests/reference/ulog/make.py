"""Writes the logs of this folder and reads them back by pyulog: needs numpy and pyulog.

    python3 make.py FOLDER

Every value follows from the number k of its message, so that a test can calculate it.
"""

import struct
import sys
from pathlib import Path

import numpy
import pyulog

MAGIC = b"ULog\x01\x12\x35\x01"
FORMATS = {
    "sensor_gyro": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
                   "float temperature;uint32_t error_count;uint8_t[3] clip_counter;uint8_t samples;uint8_t[4] _padding0;",
    "sensor_accel": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
                    "float temperature;uint32_t error_count;uint8_t[3] clip_counter;uint8_t samples;uint8_t[4] _padding0;",
    "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;float[3] accelerometer_m_s2;",
    "combined": "uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;"
                "float[3] accelerometer_m_s2;uint32_t accelerometer_integral_dt;uint8_t accelerometer_clipping;"
                "uint8_t gyro_clipping;uint8_t accel_calibration_count;uint8_t gyro_calibration_count;",
    "esc_report": "float voltage;int16_t[2] current;uint8_t[2] _padding0;",
    "esc_status": "uint64_t timestamp;esc_report[2] esc;int8_t count;",
    "sensor_gyro_fifo": "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float dt;float scale;"
                        "int16_t[32] x;int16_t[32] y;int16_t[32] z;uint8_t samples;uint8_t[3] _padding0;",
}


def message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def keyed(kind, key, value):
    return message(kind, bytes([len(key)]) + key.encode() + value)


def head(flags=0, offsets=(0, 0, 0)):
    return MAGIC + struct.pack("<Q", 112) + message("B", bytes(8) + bytes([flags]) + bytes(7) + struct.pack("<3Q", *offsets))


def definitions(names):
    out = b"".join(message("F", (name + ":" + FORMATS[name]).encode()) for name in names)
    out += keyed("I", "char[3] sys_name", b"PX4") + keyed("I", "char[10] ver_hw", b"PX4_FMU_V6")
    out += keyed("P", "float CAL_GYRO0_XOFF", struct.pack("<f", 0.25)) + keyed("P", "int32_t TC_G_ENABLE", struct.pack("<i", 1))
    out += keyed("P", "float TC_G0_X1_0", struct.pack("<f", 0)) + keyed("P", "int32_t SYS_AUTOSTART", struct.pack("<i", 4001))
    return out


def subscribe(number, name, instance=0):
    return message("A", struct.pack("<BH", instance, number) + name.encode())


def inertial(number, k, sign):
    """1 kHz with a jitter of the message, none of the sample; the padding is not written."""
    return message("D", struct.pack("<HQQIffffI3BB", number, 1000000 + 1000 * k + k * 37 % 90, 1000000 + 1000 * k - 250, 77,
                                    sign * 0.001 * k, -0.002 * k, 0.5 + k, 25 + 0.01 * k, 0, 0, 0, 0, 1))


def flight(count=40):
    names = ["sensor_gyro", "sensor_accel", "sensor_combined", "esc_status", "esc_report"]
    out = head() + definitions(names)
    out += subscribe(0, "sensor_gyro") + subscribe(1, "sensor_gyro", 1) + subscribe(2, "sensor_accel")
    out += subscribe(3, "sensor_combined") + subscribe(4, "esc_status")
    for k in range(count):
        out += inertial(0, k, 1) + inertial(2, k, -1)
        if k % 2 == 0:
            out += inertial(1, k, 2)
        if k % 4 == 0:
            out += message("D", struct.pack("<HQ3fI3f", 3, 1000000 + 1000 * k, 0.1, 0.2, 0.3, 1000, 1.0, 2.0, 9.5))
            out += message("D", struct.pack("<HQfhhH fhhH b", 4, 1000000 + 1000 * k, 11.5, k, -k, 0, 12.5, 2 * k, 3, 0, 2))
        if k == 20:
            out += message("O", struct.pack("<H", 12)) + message("S", bytes.fromhex("2f731320250cbb12"))
    return out


def bursts(count=10):
    out = head() + definitions(["sensor_gyro_fifo"]) + subscribe(9, "sensor_gyro_fifo")
    for k in range(count):
        used = 8 if k % 2 == 0 else 5
        x, y, z = ([(s * (100 * k + i)) if i < used else 0 for i in range(32)] for s in (1, -1, 2))
        out += message("D", struct.pack("<HQQIff32h32h32hB", 9, 2000000 + 10000 * k, 2000000 + 10000 * k - 30, 77, 125.0,
                                        0.0009765625, *x, *y, *z, used))
    return out


def combined(count=24):
    """The gyro every 5 ms; the accelerometer every 10 ms, 1.25 ms earlier, in two messages each; none in the last two."""
    out = head() + message("F", ("sensor_combined:" + FORMATS["combined"]).encode()) + subscribe(3, "sensor_combined")
    for k in range(count):
        later = -1250 - 5000 * (k % 2) if k < count - 2 else 2**31 - 1
        out += message("D", struct.pack("<HQ3fIi3fI4B", 3, 1000000 + 5000 * k, 0.1 * k, 0.2, 0.3, 5000, later,
                                        float(k // 2), -0.5 * (k // 2), 9.5, 5000, 0, 0, 0, 0))
    return out


def appended():
    """A crash log behind the samples; the last message before it was cut off by the crash."""
    def made(place):
        out = head(1, (place, 0, 0)) + definitions(["sensor_gyro"]) + subscribe(0, "sensor_gyro")
        return out + b"".join(inertial(0, k, 1) for k in range(10)) + inertial(0, 10, 1)[:20]
    out = made(len(made(0)))
    return out + message("M", bytes([0, 17]) + b"char[5] hardfault" + b"fault")


def check(path, topic, instance, field, expected):
    log = pyulog.ULog(str(path))
    data = log.get_dataset(topic, instance).data[field]
    assert len(data) == len(expected) and numpy.array_equal(data, numpy.asarray(expected, data.dtype)), (path, field)


def main(folder):
    folder = Path(folder)
    (folder / "flight.ulg").write_bytes(flight())
    (folder / "bursts.ulg").write_bytes(bursts())
    (folder / "appended.ulg").write_bytes(appended())
    (folder / "combined.ulg").write_bytes(combined())
    k = numpy.arange(40)
    check(folder / "flight.ulg", "sensor_gyro", 0, "x", 0.001 * k)
    check(folder / "flight.ulg", "sensor_gyro", 1, "x", 0.002 * k[::2])
    check(folder / "flight.ulg", "sensor_accel", 0, "temperature", 25 + 0.01 * k)
    check(folder / "flight.ulg", "sensor_accel", 0, "timestamp_sample", 1000000 + 1000 * k - 250)
    check(folder / "flight.ulg", "esc_status", 0, "esc[1].current[0]", 2 * k[::4])
    check(folder / "bursts.ulg", "sensor_gyro_fifo", 0, "y[3]", -(100 * numpy.arange(10) + 3))
    check(folder / "combined.ulg", "sensor_combined", 0, "accelerometer_timestamp_relative",
          [-1250 - 5000 * (k % 2) if k < 22 else 2**31 - 1 for k in range(24)])
    check(folder / "combined.ulg", "sensor_combined", 0, "accelerometer_m_s2[1]", [-0.5 * (k // 2) for k in range(24)])
    check(folder / "appended.ulg", "sensor_gyro", 0, "x", 0.001 * numpy.arange(10))


if __name__ == "__main__":
    main(*sys.argv[1:])
