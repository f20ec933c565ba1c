#!/usr/bin/env python3
"""Times the Python package beside allantools, in one run, and prints a Markdown page.

usage: python.py WHEEL [--bench BENCH_ALLAN] > bench/results/python.md
WHEEL is what script/wheel makes; BENCH_ALLAN the C++ benchmark of the same library, for the overhead of Python. Both packages are
installed into fresh environments, from local files.
"""

import argparse
import json
import os
import pathlib
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

IMPORTS = 15
PAIRS = 7
ALL = sorted(os.sched_getaffinity(0))

IMPORT = "import time; t = time.perf_counter(); import {}; print(time.perf_counter() - t)"

DEVIATION = """
import json, os, sys, time
import numpy
processors, ours = int(sys.argv[1]), sys.argv[2] == "ours"
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:processors])
rng = numpy.random.default_rng(1)
x = rng.standard_normal(10**7) + numpy.cumsum(1e-4 * rng.standard_normal(10**7)) + 9.8
factors = json.loads(sys.argv[3])
if ours:
    import tumble
    call = lambda: tumble.allan_deviation(x, 1.0, taus=factors).deviation
else:
    import allantools
    call = lambda: allantools.oadev(x, rate=1.0, data_type="freq", taus=factors)[1]
repeats = 5 if ours else 1
real, cpu = [], []
for _ in range(repeats):
    t, c = time.perf_counter(), time.process_time()
    found = call()
    real.append(time.perf_counter() - t)
    cpu.append(time.process_time() - c)
real.sort(), cpu.sort()
print(json.dumps([1e3 * real[repeats // 2], 1e3 * cpu[repeats // 2], list(found)]))
"""

LAYERS = """
import json, os, time
import numpy, tumble
from tumble import _tumble
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:1])
x = numpy.random.default_rng(1).standard_normal(10**7)
options = (10.0, 0.25, 0.95, None, True, True)
pairs = []
for _ in range(11):
    c = time.process_time(); tumble.allan_deviation(x, 1.0, taus="log"); whole = time.process_time() - c
    c = time.process_time(); _tumble.deviations(x, _tumble.Stability.oadev, 1.0, False, [], *options)
    pairs.append((1e3 * whole, 1e3 * (time.process_time() - c)))
print(json.dumps([sorted(column)[5] for column in zip(*pairs)]))
"""


def factors():
    """104 factors of 10^7 samples, as averaging_factors of tumble/math/stability/allan.hpp gives them for 16 a decade."""
    steps, found, octave = 5, [], 1
    while octave <= 10**7 // 2:
        rounded = min(octave, 16)
        for k in range(steps):
            factor = int(rounded * 2.0 ** (k / steps) + 0.5) * (octave // rounded)
            if factor <= 10**7 // 2 and (not found or factor > found[-1]):
                found.append(factor)
        octave *= 2
    return found


def free_factors():
    """104 factors between 1 and 10^6.5, even in their logarithm, as numpy.logspace gives them: none is made of others."""
    return sorted({int(10.0 ** (6.5 / 112.0 * k)) for k in range(113)})


def run(*words):
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout


def installed(folder, house, *packages):
    """A fresh environment: its Python, seconds of pip install, and MB that it added."""
    run(sys.executable, "-m", "venv", folder)
    python = folder / "bin/python"
    run(python, "-m", "pip", "download", "-q", "-d", house, *packages)
    before = size(folder)
    begin = time.perf_counter()
    run(python, "-m", "pip", "install", "-q", "--no-index", "--find-links", house, *packages)
    return python, time.perf_counter() - begin, size(folder) - before


def size(folder):
    return sum(path.lstat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink()) / 1e6


def median_import(pythons):
    """Milliseconds of each import, one after the other, so that a busy machine is the same for all."""
    spent = {name: [] for name in pythons}
    for _ in range(IMPORTS):
        for name, (python, module) in pythons.items():
            spent[name].append(1e3 * float(run(python, "-c", IMPORT.format(module))))
    return {name: statistics.median(times) for name, times in spent.items()}


def deviations(ours, theirs, asked):
    """Medians over pairs: milliseconds on one processor and two, ratios, and the greatest disagreement."""
    asked = json.dumps(asked)
    rows, disagreement = [], 0.0
    for _ in range(PAIRS):
        _, slow_cpu, slow_found = json.loads(run(theirs, "-c", DEVIATION, 1, "theirs", asked))
        slow_real, _, _ = json.loads(run(theirs, "-c", DEVIATION, 2, "theirs", asked))
        _, one_cpu, found = json.loads(run(ours, "-c", DEVIATION, 1, "ours", asked))
        both_real, _, _ = json.loads(run(ours, "-c", DEVIATION, 2, "ours", asked))
        rows.append((slow_cpu, one_cpu, slow_cpu / one_cpu, slow_real, both_real, slow_real / both_real))
        disagreement = max(disagreement, max(abs(a / b - 1.0) for a, b in zip(found, slow_found, strict=True)))
    return [statistics.median(column) for column in zip(*rows)], disagreement


def hundred_in_cpp(program):
    """Processor time of the C++ benchmark of the same 104 factors on one processor."""
    os.sched_setaffinity(0, ALL[:1])
    try:
        text = run(program, "--benchmark_filter=^hundred_factors", "--benchmark_format=json", "--benchmark_repetitions=5")
    finally:
        os.sched_setaffinity(0, ALL)
    return next(row["cpu_time"] for row in json.loads(text)["benchmarks"] if row.get("aggregate_name") == "median")


def page(wheel, bench, folder):
    house, other_house = folder / "house", folder / "other"
    ours, our_install, our_size = installed(folder / "ours", house, wheel)
    theirs, their_install, their_size = installed(folder / "theirs", other_house, "allantools")
    imports = median_import({"numpy": (ours, "numpy"), "tumble": (ours, "tumble"), "tumble, numpy": (ours, "tumble, numpy"),
                             "first": (ours, "tumble, numpy; tumble.allan_deviation(numpy.arange(1000.0) % 7, 1.0)"),
                             "allantools": (theirs, "allantools")})
    (slow, one, ratio, slow_real, both, both_ratio), disagreement = deviations(ours, theirs, factors())
    free, free_disagreement = deviations(ours, theirs, free_factors())
    whole, core = json.loads(run(ours, "-c", LAYERS))
    versions = json.loads(run(theirs, "-c", "import json, numpy, allantools; print(json.dumps([numpy.__version__, "
                              "allantools.__version__]))"))
    print(f"""# Python package beside allantools

Machine: {len(ALL)} processors, {platform.system()}. CPython {platform.python_version()}, numpy {versions[0]}, allantools {versions[1]}. One run of
`bench/python.py`; imports are medians of {IMPORTS} fresh processes, deviations of {PAIRS} pairs, taken in turn. The machine may be busy:
processor time where it says so.

| what | ours | allantools |
|---|---:|---:|
| wheel [MB] | {wheel.stat().st_size / 1e6:.1f} | |
| pip install from local files, numpy included [s] | {our_install:.1f} | {their_install:.1f} |
| on disk, numpy included [MB] | {our_size:.0f} | {their_size:.0f} |
| import [ms] | {imports["tumble"]:.0f} | {imports["allantools"]:.0f} |
| import together with numpy [ms] | {imports["tumble, numpy"]:.0f} | {imports["allantools"]:.0f} |
| numpy alone [ms] | {imports["numpy"]:.0f} | |
| both, and the first deviation of a session [ms] | {imports["first"]:.0f} | |

## `allan_deviation` of 10^7 samples of a NumPy array at {len(factors())} averaging times

Ours with noise type, degrees of freedom and limits; allantools gives the deviations alone. They agree to
{max(disagreement, free_disagreement):.1e}.

| averaging times | processors | ours [ms] | allantools [ms] | ratio |
|---|---|---:|---:|---:|
| as `allan_deviation` chooses them, 16 a decade | one (processor time) | {one:.1f} | {slow:.0f} | {ratio:.1f} |
| | two (real time) | {both:.1f} | {slow_real:.0f} | {both_ratio:.1f} |
| as `numpy.logspace` gives them | one (processor time) | {free[1]:.1f} | {free[0]:.0f} | {free[2]:.1f} |
| | two (real time) | {free[4]:.1f} | {free[3]:.0f} | {free[5]:.1f} |

The sums of the first are made of each other; those of the second share no factors, so that each takes all samples for itself.

Of a call with log-spaced averaging times, one processor: {whole:.1f} ms in all, {core:.1f} ms in the module (Python adds
{100 * (whole / core - 1):.1f} %).""")
    if bench:
        print(f"The C++ benchmark `hundred_factors` takes {hundred_in_cpp(bench):.1f} ms in the same run.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=pathlib.Path)
    parser.add_argument("--bench", type=pathlib.Path)
    given = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        page(given.wheel.resolve(), given.bench, folder)
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
