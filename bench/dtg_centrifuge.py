#!/usr/bin/env python3
"""Wall time of `tumble identify` for a long test on the centrifuge, and where it goes.

usage: dtg_centrifuge.py PROGRAM [--rounds N] [--output FILE.md]

PROGRAM is build/release/tumble. The test is plans/dtg_centrifuge.toml with 20 levels of 15 min, 1 g to 20 g, at 100 Hz in 5
power-ups: 9 million samples of gyro, gyro_y, reference gyro and two angles, simulated with seed 1, as HDF5. The parts
are told apart by further runs: `tumble inspect` reads, hashes and checks the same file, and a plain read of its bytes and
their SHA-256 with OpenSSL stand for the file alone.
"""

import argparse
import hashlib
import os
import re
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

from identify import ROOT, machine, measure


def plan_text(levels=20, minutes=15, runs=5, radius=2.5):
    head = (ROOT / "plans/dtg_centrifuge.toml").read_text().split("[[schedule]]")[0]
    head = re.sub(r'rate   = "50 Hz"', 'rate   = "100 Hz"', head)
    head = re.sub(r"oversampling.*", "oversampling = 1", head)
    head = head.replace("[settings]", '[settings]\naveraging = "0 s"\nreference_averaging = "0 s"')
    head = re.sub(r"\[\[limit\]\].*?\n\n", "", head, flags=re.S)
    numbers = str(list(range(1, runs + 1)))
    text = head + f'[[schedule]]\nlabel = "static"\nduration = "1 min"\nrun = {numbers}\n'
    for level in range(1, levels + 1):
        arm = (level * 9.80665 / radius) ** 0.5 * 180 / 3.141592653589793
        text += (f'[[schedule]]\nlabel = "spin {level}"\nduration = "{minutes * 60 + 20} s"\nrun = {numbers}\n'
                 f'arm = {{rate = "{arm:.4f} deg/s"}}\ntable = {{rate = "{40 - arm:.4f} deg/s"}}\n')
    return text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--output")
    options = parser.parse_args()
    header = machine()
    with tempfile.TemporaryDirectory() as folder:
        plan, data, result = f"{folder}/plan.toml", f"{folder}/data.h5", f"{folder}/result.json"
        Path(plan).write_text(plan_text())
        subprocess.run([options.program, "simulate", plan, "--seed", "1", "-o", data], check=True, capture_output=True)
        jobs = {"`identify`, regression": ["identify", plan, data, "-o", result],
                "`identify`, fourier": ["identify", plan, data, "-o", result, "--set", "estimator=fourier"],
                "`inspect` of the file: reading, hash, checks": ["inspect", data]}
        rows = {name: [measure([options.program, *job]) for _ in range(options.rounds)] for name, job in jobs.items()}
        reads = []
        for _ in range(options.rounds):
            begin = time.perf_counter()
            content = Path(data).read_bytes()
            middle = time.perf_counter()
            hashlib.sha256(content).hexdigest()
            reads.append((middle - begin, time.perf_counter() - middle))
        size = os.path.getsize(data)
    lines = ["# 20 levels of 15 min at 100 Hz in 5 power-ups on the centrifuge", "", header,
             f"Whole processes from start to exit, result file written; {options.rounds} runs each, the file of "
             f"{size / 1e6:.0f} MB in the page cache.", "",
             "| job | wall median [s] | wall min | wall max | processor median [s] | peak memory [MB] |",
             "|---|---:|---:|---:|---:|---:|"]
    for name, runs in rows.items():
        wall, cpu, memory = zip(*runs)
        lines.append(f"| {name} | {statistics.median(wall):.2f} | {min(wall):.2f} | {max(wall):.2f} "
                     f"| {statistics.median(cpu):.2f} | {max(memory):.0f} |")
    plain, hashed = (statistics.median(part) for part in zip(*reads))
    lines += ["", f"For comparison: bytes of the file into memory {plain:.2f} s, their SHA-256 on one core {hashed:.2f} s."]
    text = "\n".join(lines) + "\n"
    print(text)
    if options.output:
        Path(options.output).write_text(text)


if __name__ == "__main__":
    main()
