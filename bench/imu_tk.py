#!/usr/bin/env python3
"""Times `tumble identify imu_multi_position` and imu_tk on the same recording, one after the other, and prints Markdown.

usage: imu_tk.py build/release/tumble CHECKOUT > bench/results/imu_tk.md

CHECKOUT is one of https://github.com/Kyle-ak/imu_tk (BSD), the tool of Tedaldi, Pretto and Menegatti; its bin/test_data
is the recording. Its library is built here in a temporary folder, optimised, with what draws pictures and waits for keys
left out, and setters that promise a value and return none made void (today's compilers take them at their word); that needs Ceres and Eigen (Debian: libceres-dev, libeigen3-dev), which nothing of ours is linked to. It runs as
its own program test_imu_calib does: single samples, 50 s of initial rest, gravity 9.81744 m/s^2.
"""

import json
import pathlib
import platform
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time

REPEATS = 7

WITHOUT_PICTURES = """
#pragma once
#include <vector>
#include "imu_tk/base.h"
namespace imu_tk {
struct Plot {
  template <typename... Any> void plotIntervals(const Any&...) {}
  template <typename... Any> void plotSamples(const Any&...) {}
};
inline void waitForKey() {}
}
"""

PROGRAM = """
#include <iostream>
#include "imu_tk/io_utils.h"
#include "imu_tk/calibration.h"
using namespace imu_tk;
int main(int, char** files) {
  std::vector<TriadData> forces, rates;
  importAsciiData(files[1], forces, TIMESTAMP_UNIT_SEC);
  importAsciiData(files[2], rates, TIMESTAMP_UNIT_SEC);
  CalibratedTriad force, rate;
  force.setBias(Eigen::Vector3d(32768, 32768, 32768));
  rate.setScale(Eigen::Vector3d(1.0 / 6258.0, 1.0 / 6258.0, 1.0 / 6258.0));
  MultiPosCalibration calibration;
  calibration.setInitStaticIntervalDuration(50.0);
  calibration.setInitAccCalibration(force);
  calibration.setInitGyroCalibration(rate);
  calibration.setGravityMagnitude(9.81744);
  calibration.enableAccUseMeans(false);
  calibration.calibrateAccGyro(forces, rates);
  for (const CalibratedTriad& c : {calibration.getAccCalib(), calibration.getGyroCalib()})
    std::cout << "RESULT " << 1.0 / c.scaleX() << ' ' << 1.0 / c.scaleY() << ' ' << 1.0 / c.scaleZ() << ' ' << c.biasX()
              << ' ' << c.biasY() << ' ' << c.biasZ() << std::endl;
}
"""

PLAN = """
method = "imu_multi_position"
[settings]
gravity = "9.81744 m/s^2"
[[recording]]
file = "{forces}"
columns = ["time[s]", "accelerometer_x[LSB]", "accelerometer_y[LSB]", "accelerometer_z[LSB]"]
[[recording]]
file = "{rates}"
columns = ["time[s]", "gyro_x[LSB]", "gyro_y[LSB]", "gyro_z[LSB]"]
"""


def build(checkout, folder):
    shim = folder / "imu_tk"
    shim.mkdir()
    (shim / "visualization.h").write_text(WITHOUT_PICTURES)
    header = (checkout / "include" / "imu_tk" / "calibration.h").read_text()
    (shim / "calibration.h").write_text(re.sub(r"\b(_T|int|bool) (?=(set|enable)\w+\s*\()", "void ", header))
    (folder / "main.cpp").write_text(PROGRAM)
    sources = [checkout / "src" / name for name in ("calibration.cpp", "filters.cpp", "io_utils.cpp")]
    subprocess.run(["g++", "-std=c++17", "-O3", "-DNDEBUG", "-w", f"-I{folder}", f"-I{checkout / 'include'}",
                    "-I/usr/include/eigen3", folder / "main.cpp", *sources, "-lceres", "-lglog", "-o", folder / "peer"],
                   check=True)
    return folder / "peer"


def timed(command):
    """Wall clock and processor time [s], and what it printed."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, text


def peer_values(text):
    forces, rates = [[float(v) for v in line.split()[1:]] for line in text.splitlines() if line.startswith("RESULT")]
    return {f"{kind}_{axis}_{what}": values[i + 3 * k]
            for kind, values in (("accelerometer", forces), ("gyro", rates))
            for k, what in enumerate(("scale_factor", "bias")) for i, axis in enumerate("xyz")}


def values_of(result):
    found = {p["name"]: p for p in json.loads(result.read_text())["parameters"]}
    return {name: (p["value"], p["sd"]) for name, p in found.items()}


def main():
    program, checkout = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    forces, rates = (checkout / "bin" / "test_data" / f"xsens_{kind}.mat" for kind in ("acc", "gyro"))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        peer = build(checkout, folder)
        plan, result = folder / "plan.toml", folder / "result.json"
        plan.write_text(PLAN.format(forces=forces, rates=rates))
        mine, theirs = [], []
        for _ in range(REPEATS):
            mine.append(timed([program, "identify", plan, "-o", result]))
            theirs.append(timed([peer, forces, rates]))
        ours, others = values_of(result), peer_values(theirs[-1][2])
    print("# imu_multi_position against imu_tk\n")
    print(f"`tumble identify` and imu_tk on imu_tk's recording of an Xsens MTi (512 s at 100 Hz), from its two text files to the"
          f"\nresult, median of {REPEATS} runs that take turns, on {platform.machine()}. `bench/imu_tk.py`.\n")
    print("| | wall clock [s] | processor [s] |\n|---|---|---|")
    median = lambda runs, i: statistics.median(run[i] for run in runs)
    for label, runs in (("tumble", mine), ("imu_tk", theirs)):
        print(f"| {label} | {median(runs, 0):.3f} | {median(runs, 1):.3f} |")
    print(f"| ratio | {median(theirs, 0) / median(mine, 0):.0f} | {median(theirs, 1) / median(mine, 1):.0f} |\n")
    print("| parameter | tumble | +- | imu_tk |\n|---|---|---|---|")
    for key, value in others.items():
        print(f"| `{key}` | {ours[key][0]:.3f} | {ours[key][1]:.3f} | {value:.3f} |")


main()
