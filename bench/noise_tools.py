#!/usr/bin/env python3
"""Noise terms of simulated gyros by `tumble identify allan_noise` and by public tools, from the same recordings.

usage: noise_tools.py build/release/tumble [--recordings 10] [--imu-utils CHECKOUT] [--figure FILE.svg] > bench/results/noise_tools.md

Needs numpy and h5py. Compared as far as they are there:
  allantools               PyPI; a deviation is all it gives, so its curve is read as tutorials read it: at 1 s and 3 s
  allan-variance           PyPI, Nikolay Mayorov
  allan_variance_analyzer  PyPI, Varun Agrawal: the procedure of ori-drs/allan_variance_ros, whose fit it has word for word
  imu_utils                github.com/gaowenliang/imu_utils, its curve and its fit built here without ROS (Ceres, Eigen);
                           CHECKOUT may be the program built before
and the procedure of github.com/rpng/kalibr_allan (MATLAB): lines of slope -1/2 and +1/2 by the means of the logarithms
before and after the minimum of the axes' mean, on the deviations of allantools.
Each recording holds three gyros; a tool gets the same numbers as tumble. A gap is a gap in the time column, which only
tumble reads: the others are given the samples in a row, as their readers of files without time do.
"""

import argparse
import contextlib
import importlib.metadata
import io
import json
import math
import os
import pathlib
import platform
import statistics
import subprocess
import sys
import tempfile

import h5py
import numpy

DEG = math.pi / 180
HOUR = 3600.0
FLAT = math.sqrt(2 * math.log(2) / math.pi)
N_UNIT, B_UNIT, K_UNIT, Q_UNIT = DEG / 60, DEG / HOUR, DEG / HOUR / 60, DEG / HOUR

# Truths in SI (rad/s and its multiples by powers of s).
TRUTHS = {
    "walk": dict(title="White noise and rate random walk, 11 000 s at 50 Hz", rate=50, seconds=11000,
                 N=1.888e-4, K=2.557e-6),
    "flicker": dict(title="Quantisation, white noise and bias instability, 3600 s at 100 Hz", rate=100, seconds=3600,
                    Q=2 * Q_UNIT, N=0.15 * N_UNIT, B=2 * B_UNIT),
    "short": dict(title="A short record of all: 600 s at 100 Hz", rate=100, seconds=600, N=0.15 * N_UNIT,
                  B=10 * B_UNIT, K=60 * K_UNIT),
    "gap": dict(title="White noise and rate random walk, 3600 s at 100 Hz, 900 s of it missing", rate=100, seconds=3600,
                N=0.15 * N_UNIT, K=60 * K_UNIT, gap=(1200, 2100)),
    "motion": dict(title="The same whole, but the table is touched for 2 s", rate=100, seconds=3600, N=0.15 * N_UNIT,
                   K=60 * K_UNIT, motion=(1500, 1502, 1.0 * DEG)),
}
TERMS = ("Q", "N", "B", "K")
SHOWN = {"Q": (Q_UNIT, "arcsec"), "N": (N_UNIT, "deg/sqrt(h)"), "B": (B_UNIT, "deg/h"), "K": (K_UNIT, "deg/h/sqrt(h)")}
NAMES = {"quantization_noise": "Q", "angle_random_walk": "N", "bias_instability": "B", "rate_random_walk": "K"}

PLAN = """
title = "noise tools"
method = "allan_noise"
[instrument]
model = "imu"
rate = "{rate} Hz"
[site]
latitude = "0 deg"
longitude = "0 deg"
height = "0 m"
[rig]
kind = "rate_table"
[[schedule]]
label = "rest"
duration = "{seconds} s"
[truth]
gyro_quantization_noise = "{q} arcsec"
gyro_angle_random_walk = "{n} deg/sqrt(h)"
gyro_bias_instability = "{b} deg/h"
gyro_rate_random_walk = "{k} deg/h/sqrt(h)"
accelerometer_angle_random_walk = "0.03 (m/s)/sqrt(h)"
"""


def plan_of(truth):
    return PLAN.format(rate=truth["rate"], seconds=truth["seconds"], q=truth.get("Q", 0) / Q_UNIT,
                       n=truth.get("N", 0) / N_UNIT, b=truth.get("B", 0) / B_UNIT, k=truth.get("K", 0) / K_UNIT)


def recording(program, truth, seed, folder):
    """Three gyros [rad/s] and the file for tumble."""
    plan, file = folder / "plan.toml", folder / "recording.h5"
    plan.write_text(plan_of(truth))
    subprocess.run([program, "simulate", plan, "-o", file, "--seed", str(seed)], check=True, capture_output=True)
    with h5py.File(file, "r+") as data:
        for name in [name for name in data["channels"] if not name.startswith("gyro")]:
            del data["channels"][name]  # one kind of channel for all
        rates = numpy.stack([data[f"channels/gyro_{axis}"][:] * DEG for axis in "xyz"])
        if "motion" in truth:
            first, last, size = truth["motion"]
            part = slice(first * truth["rate"], last * truth["rate"])
            rates[:, part] += size * numpy.sin(numpy.linspace(0, 2 * math.pi, part.stop - part.start))
            for i, axis in enumerate("xyz"):
                data[f"channels/gyro_{axis}"][:] = rates[i] / DEG
    if "gap" not in truth:
        return rates, file
    first, last = (int(t * truth["rate"]) for t in truth["gap"])
    there = numpy.r_[0:first, last:rates.shape[1]]
    text = folder / "recording.csv"
    columns = numpy.column_stack([there / truth["rate"], rates[:, there].T / DEG])
    numpy.savetxt(text, columns, fmt=["%.4f"] + ["%.12g"] * 3, delimiter=",", comments="",
                  header="time [s],gyro_x [deg/s],gyro_y [deg/s],gyro_z [deg/s]")
    return rates[:, there], text


# ---- the tools: each returns, for every axis, {term: (value, low, high)} in SI --------------------------------------


def tumble(program, file, folder):
    result = folder / "result.json"
    subprocess.run([program, "identify", "allan_noise", file, "-o", result], check=True, capture_output=True)
    found = json.loads(result.read_text())
    axes = {"x": {}, "y": {}, "z": {}}
    for one in found["parameters"]:
        channel, name = one["name"].split(".", 1)
        term = NAMES.get(name, name)
        unit = SHOWN[term][0] if term in SHOWN else 1.0
        low, high = one["interval95"]
        axes[channel[-1]][term] = (one["value"] * unit, low * unit, high * unit)
    curves = {}
    for curve in found["curves"]:
        if curve["name"].endswith("allan_deviation"):
            unit = {"deg/h": B_UNIT}[curve["y"]["unit"]]
            curves[curve["name"][5]] = {key: numpy.array(values) * scale for key, values, scale in (
                ("tau", curve["x"]["values"], 1.0), ("dev", curve["y"]["values"], unit),
                ("low", curve["band"]["lower"], unit), ("high", curve["band"]["upper"], unit))}
    warnings = [f["message"] for f in found["findings"] if f["severity"] != "info"]
    return list(axes.values()), list(curves.values()), warnings


def plain(**terms):
    return {term: (value, None, None) for term, value in terms.items()}


def with_allantools(rates, rate):
    import allantools
    results, curves = [], []
    for series in rates:
        tau, dev, err, _ = allantools.oadev(series, rate=rate, data_type="freq", taus="octave")
        curves.append((tau, dev, err))
        fine = allantools.oadev(series, rate=rate, data_type="freq", taus=[1.0, 3.0])[1]
        results.append(plain(N=fine[0], B=dev.min() / FLAT, K=fine[1]))
    return results, curves


def with_mayorov(rates, rate):
    import allan_variance
    results = []
    for series in rates:
        tau, avar = allan_variance.compute_avar(series, 1.0 / rate)
        found, _ = allan_variance.estimate_parameters(tau, avar)
        results.append(plain(Q=found["quantization"], N=found["white"], B=found["flicker"], K=found["walk"],
                             R=found["ramp"]))
    return results


def with_analyzer(rates, rate):
    from allan_variance_analyzer import analysis, statistics as deviations
    longest = min(1000.0, rates.shape[1] / rate / 3)
    periods = numpy.arange(0.1, longest, step=0.1)
    data = numpy.concatenate([rates.T, rates.T], axis=1)
    with contextlib.redirect_stderr(io.StringIO()):
        dev = numpy.sqrt(deviations.compute_allan_variances(data, periods, rate, 0))[:, :3]
    break_point = numpy.argmin(abs(periods - 10.0))
    white, _ = analysis.compute_white_noise_params(periods, dev, break_point)
    walk, _ = analysis.compute_rate_random_walk(periods, dev)
    least, _ = analysis.compute_bias_instability(dev)
    return [plain(N=white[i], B=least[i], K=walk[i]) for i in range(3)]


def with_lines_about_minimum(rates, rate):
    import allantools
    devs = []
    for series in rates:
        tau, dev, _, _ = allantools.oadev(series, rate=rate, data_type="freq",
                                          taus=numpy.logspace(math.log10(1.0 / rate), math.log10(len(series) / rate / 3), 60))
        devs.append(dev)
    mean = numpy.sqrt(numpy.mean(numpy.square(devs), axis=0))
    least = int(numpy.argmin(mean))
    before, after = slice(0, least + 1), slice(least, None)
    white = math.exp(numpy.mean(numpy.log(mean[before] * numpy.sqrt(tau[before]))))
    walk = math.exp(numpy.mean(numpy.log(mean[after] / numpy.sqrt(tau[after])))) * math.sqrt(3.0)
    return [plain(N=white, K=walk)]  # one for the three axes


IMU_UTILS = """
#include <cstdio>
#include "gyr_lib/allan_gyr.h"
#include "gyr_lib/fitallan_gyr.h"
int main(int, char** argv) {
  const double rate = std::atof(argv[1]);
  std::freopen(argv[2], "rb", stdin);
  imu::AllanGyr gyro("gyr", 100);
  double value;
  for (long i = 0; std::fread(&value, sizeof value, 1, stdin) == 1; ++i) gyro.pushRadPerSec(value, i / rate);
  gyro.calc();
  imu::FitAllanGyr fit(gyro.getVariance(), gyro.getTimes(), gyro.getFreq());
  std::printf("RESULT %.17g %.17g %.17g %.17g %.17g %.17g\\n", fit.getQ(), fit.getN(), fit.getB(), fit.getK(),
              fit.getWhiteNoise(), fit.getBiasInstability());
}
"""


def build_imu_utils(checkout, folder):
    if os.path.isfile(checkout):
        return os.path.abspath(checkout)  # built before
    (folder / "main.cpp").write_text(IMU_UTILS)
    program = folder / "imu_utils"
    source = pathlib.Path(checkout) / "src"
    subprocess.run(["c++", "-std=c++17", "-O2", "-w", "-I", source, "-I", "/usr/include/eigen3", folder / "main.cpp",
                    source / "gyr_lib/allan_gyr.cpp", source / "gyr_lib/fitallan_gyr.cpp", "-o", program, "-lceres",
                    "-lglog"], check=True)
    return program


def with_imu_utils(program, rates, rate, folder):
    results = []
    for series in rates:
        series.tofile(folder / "series.bin")
        text = subprocess.run([program, str(rate), folder / "series.bin"], check=True, capture_output=True, text=True).stdout
        q, n, b, k, white, least = map(float, text.split("RESULT")[1].split())
        results.append({**plain(Q=q * DEG, N=n * N_UNIT, B=b * B_UNIT, K=k * K_UNIT), "gyr_n": white, "gyr_w": least})
    return results


# ---- figures ---------------------------------------------------------------------------------------------------------


def digits(value, count):
    return f"{float(f'{value:.{count}g}'):g}"


def summary(draws, term, truth):
    values = [one[term] for one in draws if term in one and one[term][0] > 0.0]
    if not values:
        return "none reported", len(values)
    estimates = [value[0] for value in values]
    if not truth:
        unit, name = SHOWN[term]
        return f"**reports {statistics.median(estimates) / unit:.3g} {name}** in {100 * len(values) / len(draws):.0f} %", len(values)
    ratios = [100 * (estimate / truth - 1) for estimate in estimates]
    mean, sd = statistics.fmean(ratios), statistics.stdev(ratios) if len(ratios) > 1 else math.nan
    text = f"{'+' if mean > 0 else ''}{digits(mean, 3)} +- {digits(sd / math.sqrt(len(ratios)), 1)} %, scatter {digits(sd, 2)} %"
    if len(values) < len(draws):
        text += f", in {100 * len(values) / len(draws):.0f} %"
    if values[0][1] is not None:
        half = statistics.fmean((value[2] - value[1]) / 2 / truth * 100 for value in values)
        held = sum(low <= truth <= high for _, low, high in values)
        text += f"; states +-{digits(half, 2)} % (95 %), holds in {held} of {len(values)}"
    return text, len(values)


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def deviation_of(truth, tau):
    return numpy.sqrt(3 * (truth.get("Q", 0) / tau) ** 2 + truth.get("N", 0) ** 2 / tau + (FLAT * truth.get("B", 0)) ** 2 +
                      truth.get("K", 0) ** 2 * tau / 3)


def band_coverage(truth, ours, theirs):
    """How often a band of the deviation holds the true one at the longest tau that both have."""
    tau = max(t for t in theirs[0][0] if t <= ours[0]["tau"][-1])
    true = deviation_of(truth, tau)
    them = [dev[list(taus).index(tau)] - 1.96 * err[list(taus).index(tau)] <= true <=
            dev[list(taus).index(tau)] + 1.96 * err[list(taus).index(tau)] for taus, dev, err in theirs]
    us = [numpy.interp(tau, one["tau"], one["low"]) <= true <= numpy.interp(tau, one["tau"], one["high"]) for one in ours]
    return tau, sum(us), sum(them), len(them)


def compare(options, key, folder, tools):
    truth = TRUTHS[key]
    draws = {"tumble": []}
    ours, theirs, warnings, raw = [], [], [], []
    for seed in range(1, options.recordings + 1):
        rates, file = recording(options.program, truth, 100 * seed + 7, folder)
        found, curves, said = tumble(options.program, file, folder)
        draws["tumble"] += found
        ours += curves
        warnings += said
        for name, tool in tools.items():
            try:
                answer = tool(rates, truth["rate"])
            except Exception as error:  # a tool that fails is part of the comparison
                print(f"{key}: {name}: {error}", file=sys.stderr)
                continue
            if isinstance(answer, tuple):
                theirs += answer[1]
                answer = answer[0]
            draws.setdefault(name, []).extend(answer)
    return truth, draws, ours, theirs, warnings


def table(truth, draws):
    lines = ["| tool | " + " | ".join(TERMS) + " |", "|---" * 5 + "|"]
    lines.append("| *truth* | " + " | ".join(
        f"*{truth[term] / SHOWN[term][0]:.4g} {SHOWN[term][1]}*" if term in truth else "*none*" for term in TERMS) + " |")
    for name, found in draws.items():
        lines.append(f"| {name} | " + " | ".join(summary(found, term, truth.get(term))[0] for term in TERMS) + " |")
    return lines


def figure(path, truth, draws):
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "noise_tools"
    import matplotlib.pyplot as plt
    names = list(draws)
    fig, axes = plt.subplots(1, 2, figsize=(6.8, 3.6))
    for axis, term in zip(axes, ("N", "K")):
        for row, name in enumerate(names):
            values = [one[term] for one in draws[name] if term in one]
            for i, (value, low, high) in enumerate(values):
                y = -row + 0.6 * ((i + 0.5) / len(values) - 0.5)
                if low is not None:
                    axis.plot([low / truth[term], high / truth[term]], [y, y], color="#1f6fb4", lw=0.8)
                axis.plot(value / truth[term], y, ".", ms=3, color="#1f6fb4" if low is not None else "#c0504d")
        axis.axvline(1.0, color="k", lw=0.8)
        axis.set_yticks([-row for row in range(len(names))], names if term == "N" else [])
        axis.set_xlabel(f"{term}, estimate over truth")
        axis.grid(axis="x", alpha=0.3)
    axes[0].set_xlim(0.97, 1.03)
    axes[1].set_xlim(0.2, 1.8)
    fig.tight_layout()
    fig.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--recordings", type=int, default=10)
    parser.add_argument("--imu-utils")
    parser.add_argument("--figure")
    parser.add_argument("--only", nargs="*", default=list(TRUTHS))
    options = parser.parse_args()
    options.program = os.path.abspath(options.program)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tools, absent = {}, []
        for package, label, tool in (("allantools", "allantools, read at 1 s, 3 s and the minimum", with_allantools),
                                     ("allan-variance", "allan-variance", with_mayorov),
                                     ("allan-variance-analyzer", "allan_variance_analyzer", with_analyzer),
                                     ("allantools", "kalibr_allan's procedure", with_lines_about_minimum)):
            if version(package):
                tools[label] = tool
            else:
                absent.append(label)
        if options.imu_utils:
            program = build_imu_utils(options.imu_utils, folder)
            tools["imu_utils, its fit"] = lambda rates, rate: with_imu_utils(program, rates, rate, folder)
        else:
            absent.append("imu_utils")
        print("# Noise terms by tumble and by public tools\n")
        print(f"{3 * options.recordings} gyros of each kind ({options.recordings} recordings of three), simulated by `tumble simulate`; "
              f"the same numbers to every tool. {platform.machine()}, Python {platform.python_version()}, numpy {numpy.__version__}, "
              + ", ".join(f"{package} {version(package)}" for package in ("allantools", "allan-variance", "allan-variance-analyzer")
                          if version(package)) + ". "
              + (f"Not here: {', '.join(absent)}. " if absent else "") + "`bench/noise_tools.py`.\n")
        print("Mean of estimate over truth less one, with its standard error; scatter of one estimate. Where a tool states an interval: its mean half-width "
              "and how often it holds the truth. Bold: a term that is not there.\n")
        for key in options.only:
            truth, draws, ours, theirs, warnings = compare(options, key, folder, tools)
            print(f"## {truth['title']}\n")
            print("\n".join(table(truth, draws)) + "\n")
            for one in draws.get("imu_utils, its fit", [])[:1]:
                print(f"imu_utils writes `gyr_n` {one['gyr_n']:.4g} and `gyr_w` {one['gyr_w']:.4g} (first gyro, `rad/s`); N is "
                      f"{truth['N']:.4g} rad/s/sqrt(Hz), K {truth.get('K', 0):.4g} rad/s^2/sqrt(Hz).\n")
            if theirs and "gap" not in truth and "motion" not in truth:
                tau, us, them, count = band_coverage(truth, ours, theirs)
                print(f"Deviation at {tau:.4g} s: the true one lies in tumble's 95 % band in {us} of {count}, within 1.96 of "
                      f"allantools' `errs` in {them}.\n")
            kinds = sorted(set(text.split(":")[0][:90] for text in warnings))
            print(f"Warnings of tumble in {len(warnings)} cases" + (": " + "; ".join(kinds[:4]) if kinds else "") + ".\n", flush=True)
            if options.figure and key == "walk":
                figure(options.figure, truth, draws)


if __name__ == "__main__":
    main()
