"""Writes counted_gyro.raw: 1 s of the gyro of counted_gyro.toml at rest. The recorder began in the middle of a frame, and one frame is
lost."""

import pathlib
import random

random.seed(3)
stream = b""
for sample in range(1000):
    step = 9 if sample == 2 else round(random.gauss(8.8, 2))
    if sample != 600:
        stream += bytes([sample % 4 << 6 | 0x10, 0, 0]) + (step % 2**22).to_bytes(3, "big")
pathlib.Path(__file__).with_suffix(".raw").write_bytes(stream[2:])
