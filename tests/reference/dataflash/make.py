"""Writes the logs of this folder and reads them back by pymavlink: needs pymavlink.

    python3 make.py FOLDER

Every value follows from the number k of its message, so that a test can calculate it.
"""

import struct
import sys
from pathlib import Path

from pymavlink import DFReader

SIZES = {"Q": "Q", "B": "B", "b": "b", "f": "f", "d": "d", "c": "h", "C": "H", "e": "i", "E": "I", "I": "I", "H": "H", "L": "i",
         "h": "h", "N": "16s", "Z": "64s", "n": "4s", "a": "32h", "M": "B"}
MESSAGES = {  # id: name, types, labels, units, multipliers
    129: ("FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds", "s---", "F---"),
    130: ("UNIT", "QbZ", "TimeUS,Id,Label", "s--", "F--"),
    131: ("MULT", "Qbd", "TimeUS,Id,Mult", "s--", "F--"),
    132: ("PARM", "QNff", "TimeUS,Name,Value,Default", "s---", "F---"),
    133: ("MSG", "QZ", "TimeUS,Message", "s-", "F-"),
    140: ("IMU", "QBffffffIIfBBHH", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH,AH,GHz,AHz", "s#EEEooo--O--zz",
          "F-000000-00--00"),
    141: ("GYR", "QBQfff", "TimeUS,I,SampleUS,GyrX,GyrY,GyrZ", "s#sEEE", "F-F000"),
    142: ("ACC", "QBQfff", "TimeUS,I,SampleUS,AccX,AccY,AccZ", "s#sooo", "F-F000"),
    143: ("ATT", "QccCEL", "TimeUS,Roll,Pitch,Yaw,Err,Lat", "sdddmD", "FBBBCG"),
    144: ("ISBD", "QHHa", "TimeUS,N,seqno,x", "s---", "F---"),
}
UNITS = {"s": "s", "E": "rad/s", "o": "m/s/s", "O": "degC", "d": "deg", "m": "m", "D": "deglatitude", "z": "Hz", "#": "instance",
         "-": ""}
MULTIPLIERS = {"-": 0, "?": 1, "0": 1, "B": 1e-2, "C": 1e-3, "F": 1e-6, "G": 1e-7}


def layout(types):
    return "<" + "".join(SIZES[c] for c in types)


def message(number, *values):
    return b"\xa3\x95" + bytes([number]) + struct.pack(layout(MESSAGES[number][1]), *values)


def fmt(number, name, types, labels):
    length = 3 + struct.calcsize(layout(types))
    return b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", number, length, name.encode(), types.encode(), labels.encode())


def descriptions(units, without=()):
    out = b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", 128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns")
    for number, (name, types, labels, _, _) in MESSAGES.items():
        if number not in without and (units or number not in (129, 130, 131)):
            out += fmt(number, name, types, labels)
    if not units:
        return out
    for key, label in UNITS.items():
        out += message(130, 10, ord(key), label.encode())
    for key, value in MULTIPLIERS.items():
        widened = struct.unpack("<f", struct.pack("<f", value))[0]  # as ArduPilot writes them
        out += message(131, 11, ord(key), widened)
    for number, (_, _, _, unit, multiplier) in MESSAGES.items():
        if number not in without:
            out += message(129, 12, number, unit.encode(), multiplier.encode())
    return out


def parameters():
    out = message(133, 20, b"ArduCopter V4.5.1 (abcdef01)")
    for name, value in {"INS_GYROFFS_X": 0.5, "INS_GYROFFS_Y": 0.0, "INS_GYR2OFFS_X": 0.25, "INS_ACCSCAL_X": 1.0,
                        "INS_ACCSCAL_Y": 1.5, "ATC_RAT_RLL_P": 0.1}.items():
        out += message(132, 21, name.encode(), value, 0.0)
    return out


def imu(k, instance):
    return message(140, 5000000 + 2500 * k + k * 53 % 300, instance, 0.001 * k, -0.002 * k, 0.5 + k, 1 + instance + 0.25 * k, -3.0 * k,
                   9.75, 0, 0, 30 + 0.5 * k, 1, 1, 1000, 1000)


def rows(count=30):
    for k in range(count):
        yield imu(k, 0) + imu(k, 1)
        if k % 3 == 0:
            yield message(143, 5000000 + 2500 * k, 100 * k, -50 * k, 36000, 7 * k, -353632610 + k)


def raw(count=30):
    for k in range(count):
        yield message(141, 6000000 + 1000 * k + 400, 0, 6000000 + 1000 * k, 0.001 * k, 0.002 * k, -0.5 * k)
        yield message(142, 6000000 + 1000 * k + 450, 0, 6000000 + 1000 * k + 20, 0.5 * k, 9.75, -k)
        if k % 10 == 0:
            yield imu(k, 0) + message(144, 6000000 + 1000 * k, 1, k, *range(32))


def check(path, name, field, expected, instance=None):
    log = DFReader.DFReader_binary(str(path))
    values = []
    while (found := log.recv_match(type=name)) is not None:
        if instance is None or found.I == instance:
            values.append(getattr(found, field))
    assert values == expected, (path, name, field, values, expected)


def single(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def main(folder):
    folder = Path(folder)
    (folder / "copter.bin").write_bytes(descriptions(True) + parameters() + b"".join(rows()))
    (folder / "old.bin").write_bytes(descriptions(False) + parameters() + b"".join(rows(12)) + b"\xff" * 300)
    (folder / "raw.bin").write_bytes(descriptions(True) + parameters() + b"".join(raw()))
    (folder / "no_fmt.bin").write_bytes(descriptions(True, without=(140,)) + b"".join(rows(12)))
    check(folder / "copter.bin", "IMU", "GyrX", [single(0.001 * k) for k in range(30)], 0)
    check(folder / "copter.bin", "IMU", "AccX", [single(2 + 0.25 * k) for k in range(30)], 1)
    check(folder / "copter.bin", "ATT", "Pitch", [-50 * k * 0.01 for k in range(0, 30, 3)])
    check(folder / "copter.bin", "ATT", "Lat", [(-353632610 + k) * 1e-7 for k in range(0, 30, 3)])
    check(folder / "old.bin", "ATT", "Yaw", [360.0] * 4)
    check(folder / "raw.bin", "GYR", "SampleUS", [6000000 + 1000 * k for k in range(30)])


if __name__ == "__main__":
    main(*sys.argv[1:])
