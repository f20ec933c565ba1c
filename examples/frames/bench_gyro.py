"""Writes bench_gyro.raw: 10 s of the gyro of bench_gyro.toml at rest, with what happens to streams: three frames are lost, one is
damaged, and the recorder began in the middle of a frame."""

import pathlib
import random
import struct


def crc16(data):
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021) & 0xFFFF if crc & 0x8000 else crc << 1
    return crc


def frame(sample, rate, temperature):
    body = bytes([sample % 256, 1]) + rate.to_bytes(3, "little", signed=True) + struct.pack("<h", temperature)
    body += (500 * sample % 2**24).to_bytes(3, "little")
    return b"\xaa\x55" + body + struct.pack("<H", crc16(body))


random.seed(1)
stream = b""
for sample in range(2000):
    rate = 4398 if sample == 0 else round(4400 + random.gauss(0, 40))
    one = frame(sample, rate, 2500 + sample // 50)
    if sample in (700, 701, 702):
        continue
    if sample == 1500:
        one = one[:5] + bytes([one[5] ^ 0x10]) + one[6:]
    stream += one
pathlib.Path(__file__).with_suffix(".raw").write_bytes(frame(1, 0, 0)[6:] + stream)
print(frame(0, 4398, 2500).hex(" ").upper(), 4398 / 2**14)
