#!/usr/bin/env python3
"""Times bench_allan and allantools one after the other on this machine and prints a Markdown table.

usage: allan_vs_allantools.py build/release/bench/bench_allan > bench/results/allan.md
needs numpy and allantools. The data are of the same kind and size on both sides; the time does not depend on their values.
"""

import json
import platform
import statistics
import subprocess
import sys
import time

import allantools
import numpy

REPEATS = 3


def octaves(longest):
    factors = [1]
    while 2 * factors[-1] <= longest:
        factors.append(2 * factors[-1])
    return factors


def log_spaced(longest, per_decade):
    factors, k = [], 0
    while (factor := round(10 ** (k / per_decade))) <= longest:
        if not factors or factor > factors[-1]:
            factors.append(factor)
        k += 1
    return factors


def recording(samples):
    rng = numpy.random.default_rng(1)
    return rng.standard_normal(samples) + numpy.cumsum(1e-4 * rng.standard_normal(samples)) + 9.8


def median_ms(call):
    spent = []
    for _ in range(REPEATS):
        start = time.process_time()
        call()
        spent.append(1e3 * (time.process_time() - start))
    return statistics.median(spent)


def ours(program):
    text = subprocess.run([program, f"--benchmark_repetitions={REPEATS}", "--benchmark_report_aggregates_only=true",
                           "--benchmark_format=json"], check=True, capture_output=True, text=True).stdout
    return {row["run_name"].removesuffix("/process_time"): row["cpu_time"]
            for row in json.loads(text)["benchmarks"] if row["aggregate_name"] == "median"}


def theirs():
    long_record, rate = 4400000, 400.0
    long_data = recording(long_record)

    def frequency(function, data, factors, sample_rate=1.0):
        return lambda: function(data, rate=sample_rate, data_type="freq", taus=[m / sample_rate for m in factors])

    def oadev(factors):
        return frequency(allantools.oadev, long_data, factors, rate)

    million = recording(1000000)
    calls = {
        "overlapping_allan/0": oadev(octaves(long_record // 4)),
        "overlapping_allan/10": oadev(log_spaced(long_record // 4, 10)),
        "overlapping_allan/15": oadev(log_spaced(long_record // 4, 15)),
        "family/mdev": frequency(allantools.mdev, million, octaves(250000)),
        "family/ohdev": frequency(allantools.ohdev, million, octaves(250000)),
        "family/totdev": frequency(allantools.totdev, recording(100000), octaves(50000)),
        "family/mtotdev": frequency(allantools.mtotdev, recording(2000), octaves(600)),
        "family/htotdev": frequency(allantools.htotdev, recording(2000), octaves(600)),
        "family/theo1": frequency(allantools.theo1, recording(5000), [m for m in octaves(2500) if m >= 10]),
        "family/mtie": frequency(allantools.mtie, recording(100000), octaves(25000)),
    }
    return {name: median_ms(call) for name, call in calls.items()}


TITLES = {
    "overlapping_allan/0": "OADEV, 4.4e6 samples, octaves",
    "overlapping_allan/10": "OADEV, 4.4e6 samples, 10 per decade",
    "overlapping_allan/15": "OADEV, 4.4e6 samples, 15 per decade",
    "overlapping_allan_six_axes": "OADEV, 6 axes of 4.4e6 samples, 15 per decade",
    "family/mdev": "MDEV, 1e6 points, octaves",
    "family/ohdev": "OHDEV, 1e6 points, octaves",
    "family/totdev": "TOTDEV, 1e5 points, octaves",
    "family/mtotdev": "MTOTDEV, 2000 points, octaves",
    "family/htotdev": "HTOTDEV, 2000 points, octaves",
    "family/theo1": "Theo1, 5000 points, octaves",
    "family/mtie": "MTIE, 1e5 points, octaves",
}


def processor():
    with open("/proc/cpuinfo", encoding="ascii") as info:
        lines = [line for line in info if line.startswith("model name")]
    return f"{lines[0].split(':')[1].strip()}, {len(lines)} cores"


def main():
    mine, other = ours(sys.argv[1]), theirs()
    compiler = subprocess.run(["c++", "--version"], check=True, capture_output=True, text=True).stdout.splitlines()[0]
    print("# Allan family: time beside allantools\n")
    print(f"Machine: {processor()}, {platform.system()}. Compiler: {compiler}, release preset. "
          f"Python {platform.python_version()}, numpy {numpy.__version__}, allantools {allantools.__version__}. "
          f"Processor time (of all threads together: the machine may be busy), medians of {REPEATS} runs, both in one call of `bench/allan_vs_allantools.py`. Ours include noise type, edf "
          "and limits for OADEV; allantools gives the deviations alone.\n")
    print("| what | ours [ms] | allantools [ms] | ratio |\n|---|---:|---:|---:|")
    for name, title in TITLES.items():
        against = other.get(name)
        print(f"| {title} | {mine[name]:.3g} | " +
              (f"{against:.4g} | {against / mine[name]:.3g} |" if against else "not run | |"))


if __name__ == "__main__":
    main()
