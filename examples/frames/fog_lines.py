"""Writes fog_lines.txt: 6 s of the gyro of fog_lines.toml at rest. The recorder began in the middle of a line, and one line lost its
end."""

import pathlib
import random

random.seed(2)
lines = []
for sample in range(600):
    rate = 0.004178 if sample == 0 else random.gauss(0.0042, 0.0009)
    lines.append(f"{rate:.6f} {25 + sample // 100 / 100:.2f}\r\n")
lines[400] = lines[400][:5]
pathlib.Path(__file__).with_suffix(".txt").write_bytes(("3871 25.00\r\n" + "".join(lines)).encode())
