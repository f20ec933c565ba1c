#!/usr/bin/env python3
"""Times bench_imu and the sensor models of gnss-ins-sim one after the other on this machine and prints Markdown.

usage: imu_vs_gnss_ins_sim.py build/release/bench/bench_imu > bench/results/imu.md
needs numpy and gnss_ins_sim (https://github.com/Aceinna/gnss-ins-sim; not on PyPI: put its checkout on PYTHONPATH). Both
sides simulate the same instrument: bias, white noise and a first-order Markov drift on every axis of an IMU at rest.
"""

import json
import platform
import statistics
import subprocess
import sys
import time

import numpy
from gnss_ins_sim.pathgen import pathgen

REPEATS = 5
SAMPLES = 1000000
RATE = 100.0


def ours(program):
    text = subprocess.run([program, f"--benchmark_repetitions={REPEATS}", "--benchmark_report_aggregates_only=true",
                           "--benchmark_format=json"], check=True, capture_output=True, text=True).stdout
    return {row["run_name"].removesuffix("/process_time"): row["items_per_second"]
            for row in json.loads(text)["benchmarks"] if row["aggregate_name"] == "median"}


def rate_of(call):
    spent = []
    for _ in range(REPEATS):
        start = time.process_time()
        call()
        spent.append(time.process_time() - start)
    return 3 * SAMPLES / statistics.median(spent)


def theirs():
    degree_h = numpy.pi / 180 / 3600
    gyro = {"b": numpy.full(3, 10 * degree_h), "b_drift": numpy.full(3, 3.5 * degree_h),
            "b_corr": numpy.full(3, 100.0), "arw": numpy.full(3, 0.25 * numpy.pi / 180 / 60)}
    accelerometer = {"b": numpy.full(3, 1e-2), "b_drift": numpy.full(3, 3.5e-5), "b_corr": numpy.full(3, 100.0),
                     "vrw": numpy.full(3, 0.25 / 60)}
    rate, force = numpy.zeros((SAMPLES, 3)), numpy.zeros((SAMPLES, 3))
    return {"gyro_gen": rate_of(lambda: pathgen.gyro_gen(RATE, rate, gyro)),
            "acc_gen": rate_of(lambda: pathgen.acc_gen(RATE, force, accelerometer))}


def main():
    mine, peer = ours(sys.argv[1]), theirs()
    print("# Simulating an IMU at rest\n")
    print("Millions of axis-samples per second of processor time, median of", REPEATS, "on",
          f"{platform.machine()}, Python {platform.python_version()}, numpy {numpy.__version__}. `bench/imu_vs_gnss_ins_sim.py`.\n")
    print("| | million axis-samples/s | times gyro_gen |\n|---|---|---|")
    for name, value in (mine | {f"gnss-ins-sim {k}": v for k, v in peer.items()}).items():
        print(f"| {name} | {value / 1e6:.2f} | {value / peer['gyro_gen']:.1f} |")
    print("\n`imu_white_and_markov` is what the peer simulates; `imu_all_noise` has quantization, bias instability and a rate"
          "\nrandom walk besides. Terms, blocks and counters as in `tumble simulate`, without the file; the time is that of all threads together.")


main()
