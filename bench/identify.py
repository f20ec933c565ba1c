#!/usr/bin/env python3
"""Wall time and peak memory of whole `tumble` runs: a long static record to its report, and the thermal test of the demo.

usage: identify.py PROGRAM [--rounds N] [--output FILE.md]

PROGRAM is build/release/tumble. The static record is 11 000 s at 400 Hz on six axes (white noise and random walk) as HDF5;
float64 and float32; the thermal test is plans/fog_thermal_bias.toml, simulated with seed 1. Needs python3-h5py.

The recording is shaped like imu_simulation.bag of allan_variance_ros, for which the README of allan_variance_analyzer publishes
46.6 s wall and 40.6 s user on its author's machine (allan_variance_ros: 14 min 6 s). It is another file format and another
machine, so that is a published figure and not a measurement of ours.
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


PUBLISHED_WALL, PUBLISHED_USER = 46.6, 40.6  # s


def static_record(path, kind="f8", seconds=11000, rate=400.0):
    import h5py
    import numpy
    rng = numpy.random.default_rng(3)
    count = int(seconds * rate)
    with h5py.File(path, "w") as file:
        for unit, name, white, walk in [("rad/s", "gyro", 1.888e-4, 2.557e-6), ("m/s^2", "acc", 2.502e-3, 6.972e-5)]:
            for axis in "xyz":
                values = white * rate**0.5 * rng.standard_normal(count)
                values += numpy.cumsum(walk / rate**0.5 * rng.standard_normal(count))
                data = file.create_dataset(f"channels/{name}.{axis}", data=values.astype(kind))
                data.attrs["unit"] = unit
                data.attrs["rate"] = rate


def measure(commands):
    """Wall seconds, processor seconds, peak resident MB of processes one after the other."""
    walls, processors, memories = zip(*map(measure_one, commands))
    return sum(walls), sum(processors), max(memories)


def measure_one(command):
    begin = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.perf_counter() - begin
    if status != 0:
        raise SystemExit(child.stderr.read().decode())
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def machine():
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    load = os.getloadavg()[0]
    return f"{model}, {os.cpu_count()} cores, load {load:.1f} before the runs; {compiler}, preset release."


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--output")
    options = parser.parse_args()
    header = machine()
    with tempfile.TemporaryDirectory() as folder:
        static, thermal, result = f"{folder}/static.h5", f"{folder}/thermal.h5", f"{folder}/result.json"
        single, page = f"{folder}/single.h5", f"{folder}/report.html"
        static_record(static)
        static_record(single, "f4")
        plan = str(ROOT / "plans/fog_thermal_bias.toml")
        subprocess.run([options.program, "simulate", plan, "--seed", "1", "-o", thermal], check=True, capture_output=True)
        report = [options.program, "report", result, "-o", page]

        def identify(*what):
            return [options.program, "identify", *what, "-o", result]

        noise = "`allan_noise`, 11 000 s x 400 Hz x 6 channels, HDF5"
        jobs = {
            f"{noise} of float64": [identify("allan_noise", static)],
            f"{noise} of float64, file to report (HTML)": [identify("allan_noise", static), report],
            f"{noise} of float32, file to report (HTML)": [identify("allan_noise", single), report],
            "`fog_thermal_bias`, the demo's 48 power-ups at 1 Hz, HDF5": [identify(plan, thermal)],
        }
        rows = {name: [measure(job) for _ in range(options.rounds)] for name, job in jobs.items()}
        sizes = {"static": os.path.getsize(static), "thermal": os.path.getsize(thermal)}
    lines = ["# Whole runs of `tumble identify`", "", header,
             f"Whole processes from start to exit, result file written, input hashed (SHA-256) and checked; {options.rounds} "
             f"runs each, files in the page cache ({sizes['static'] / 1e6:.0f} MB and {sizes['thermal'] / 1e6:.0f} MB).", "",
             "| job | wall median [s] | wall min | wall max | processor median [s] | peak memory [MB] |",
             "|---|---:|---:|---:|---:|---:|"]
    for name, runs in rows.items():
        wall, cpu, memory = zip(*runs)
        lines.append(f"| {name} | {statistics.median(wall):.2f} | {min(wall):.2f} | {max(wall):.2f} "
                     f"| {statistics.median(cpu):.2f} | {max(memory):.0f} |")
    lines += ["", "Published for a recording of the shape of the first three (a ROS bag, on another machine, see "
              f"`bench/identify.py`): {PUBLISHED_WALL} s wall, {PUBLISHED_USER} s user. Over it, file to report:", "",
              "| samples | published wall / ours | published user / ours, processor |", "|---|---:|---:|"]
    for name, runs in rows.items():
        if "report" in name:
            wall, cpu, _ = zip(*runs)
            lines.append(f"| {name.split(' of ')[1].split(',')[0]} | {PUBLISHED_WALL / statistics.median(wall):.0f} "
                         f"| {PUBLISHED_USER / statistics.median(cpu):.0f} |")
    text = "\n".join(lines) + "\n"
    print(text)
    if options.output:
        Path(options.output).write_text(text)


if __name__ == "__main__":
    main()
