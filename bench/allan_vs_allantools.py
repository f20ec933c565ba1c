#!/usr/bin/env python3
"""Times bench_allan and allantools one after the other on this machine and prints a Markdown table.

usage: allan_vs_allantools.py build/release/bench/bench_allan > bench/results/allan.md
needs numpy and allantools. The data are of the same kind and size on both sides; the time does not depend on their values.
"""

import json
import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time

import allantools
import numpy

REPEATS = 3
PAIRS = 7
ALL_PROCESSORS = os.sched_getaffinity(0)


def factors_up_to(longest, per_decade):
    """As averaging_factors of tumble/math/stability/allan.hpp, up to 53 a decade; octaves for 0."""
    steps, factors, octave = max(1, round(per_decade * math.log10(2.0))), [], 1
    while octave <= longest:
        rounded = min(octave, 16)
        for k in range(steps):
            factor = int(rounded * 2.0 ** (k / steps) + 0.5) * (octave // rounded)
            if factor <= longest and (not factors or factor > factors[-1]):
                factors.append(factor)
        octave *= 2
    return factors


def octaves(longest):
    return factors_up_to(longest, 0)


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
    text = subprocess.run([program, "--benchmark_filter=^(overlapping_allan|family|streaming)",
                           f"--benchmark_repetitions={REPEATS}", "--benchmark_report_aggregates_only=true",
                           "--benchmark_format=json"], check=True, capture_output=True, text=True).stdout
    return {row["run_name"].removesuffix("/real_time").removesuffix("/process_time"): row["cpu_time"]
            for row in json.loads(text)["benchmarks"] if row["aggregate_name"] == "median"}


def ours_once(program, name, processors):
    """Real and processor time of one run, bound to so many processors."""
    os.sched_setaffinity(0, sorted(ALL_PROCESSORS)[:processors])
    try:
        text = subprocess.run([program, f"--benchmark_filter=^{name}", "--benchmark_format=json"], check=True,
                              capture_output=True, text=True).stdout
    finally:
        os.sched_setaffinity(0, ALL_PROCESSORS)
    row = json.loads(text)["benchmarks"][0]
    return row["real_time"], row["cpu_time"]


def hundred(program):
    """10^7 samples at 100 factors: pairs of runs, one after the other, and how well the deviations agree."""
    data = recording(10**7)
    with tempfile.NamedTemporaryFile() as file:
        data.tofile(file.name)
        lines = subprocess.run([program, "--deviations", file.name], check=True, capture_output=True,
                               text=True).stdout.split()
    factors = [int(word) for word in lines[0::2]]
    deviations = numpy.array([float(word) for word in lines[1::2]])
    pairs = []
    for _ in range(PAIRS):
        real, cpu = time.perf_counter(), time.process_time()
        found = allantools.oadev(data, rate=1.0, data_type="freq", taus=factors)
        theirs_real, theirs_cpu = 1e3 * (time.perf_counter() - real), 1e3 * (time.process_time() - cpu)
        _, one_cpu = ours_once(program, "hundred_factors", 1)
        both_real, _ = ours_once(program, "hundred_factors", 2)
        pairs.append((theirs_cpu, one_cpu, theirs_cpu / one_cpu, theirs_real, both_real, theirs_real / both_real))
    disagreement = numpy.max(numpy.abs(found[1] / deviations - 1.0))
    return len(factors), disagreement, [statistics.median(column) for column in zip(*pairs)]


def every(program):
    """Every factor of 10^6 samples: processor time on one processor, of the loops extrapolated from one factor in 10000."""
    pairs = []
    for _ in range(PAIRS):
        fast = ours_once(program, "every_factor/", 1)[1]
        plain = 1e4 * ours_once(program, "every_factor_by_loop/0", 1)[1]
        vector = 1e4 * ours_once(program, "every_factor_by_loop/1", 1)[1]
        pairs.append((fast, plain, plain / fast, vector, vector / fast))
    return [statistics.median(column) for column in zip(*pairs)]


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
        "overlapping_allan/10": oadev(factors_up_to(long_record // 4, 10)),
        "overlapping_allan/15": oadev(factors_up_to(long_record // 4, 15)),
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
    "streaming": "OADEV of a stream of 1e7 samples, 10 per decade, 0.4 MB held",
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

    count, disagreement, (their_cpu, one, one_ratio, their_real, two, two_ratio) = hundred(sys.argv[1])
    print(f"""
## 10^7 samples, {count} factors

Medians of {PAIRS} pairs of runs, one after the other. The deviations agree to {disagreement:.1e}.

| | ours [ms] | allantools [ms] | ratio |
|---|---:|---:|---:|
| one processor (processor time) | {one:.4g} | {their_cpu:.4g} | {one_ratio:.3g} |
| two processors (real time) | {two:.4g} | {their_real:.4g} | {two_ratio:.3g} |

A sum is one difference and one square a term, because the doubles of the factors are factors too (docs/decisions/033).
Integration of the phase (10 to 20 ms of processor time, in memory that an earlier run gave back) and the noise types (6 ms) are in the figures.""")
    fast, plain, plain_ratio, vector, vector_ratio = every(sys.argv[1])
    print(f"""
## Every factor of 10^6 samples

Processor time on one processor, medians of {PAIRS} runs. The loops over all n for each of the 500 000 factors are
extrapolated from 50 of them, evenly spread.

| | time [s] | ours faster by |
|---|---:|---:|
| `every_overlapping_allan` | {1e-3 * fast:.3g} | |
| loop, vectorised by the compiler | {1e-3 * plain:.3g} | {plain_ratio:.3g} |
| loop, AVX2 by hand | {1e-3 * vector:.3g} | {vector_ratio:.3g} |""")

if __name__ == "__main__":
    main()
