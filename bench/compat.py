#!/usr/bin/env python3
"""Times tumble.compat and tumble.allan_deviation beside allantools and imucal, in one process, and prints Markdown.

usage: PYTHONPATH=build/release/python PYTHON bench/compat.py > bench/results/compat.md
needs numpy, pandas, allantools and imucal: build/venv of script/python has them. Each pair of calls follows one another, so
that both meet the same machine.
"""

import contextlib
import io
import os
import pathlib
import platform
import statistics
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # imucal multiplies 3 x 3 by n x 3: threads only cost there

import allantools
import imucal
import numpy
import pandas

import tumble
import tumble.compat.allantools
import tumble.compat.imucal

QUICK = ["adev", "oadev", "mdev", "tdev", "hdev", "ohdev", "totdev", "mtie", "tierms", "gradev"]
SLOW = ["pdev", "mtotdev", "ttotdev", "htotdev", "theo1"]
SIZES = {**dict.fromkeys(QUICK, (100, 1000, 10_000, 100_000)), **dict.fromkeys(SLOW, (100, 300))}
SESSION = pathlib.Path(__file__).resolve().parents[1] / "tests/reference/imucal/annotated_session.csv"
PROCESSORS = sorted(os.sched_getaffinity(0))


def rate_of(samples):
    rng = numpy.random.default_rng(1)
    return rng.standard_normal(samples) + numpy.cumsum(1e-4 * rng.standard_normal(samples)) + 9.8


def spent(call, clock):
    start = clock()
    call()
    return clock() - start


def pairs(ours, theirs, seconds=1.0, fewest=3, most=100, clock=time.process_time):
    """Medians of ours, of theirs and of their ratio, in calls one after the other."""
    rows, end = [], time.monotonic() + seconds
    ours(), theirs()
    while len(rows) < fewest or (len(rows) < most and time.monotonic() < end):
        mine, other = spent(ours, clock), spent(theirs, clock)
        rows.append((mine, other, other / max(mine, 1e-9)))
    return [statistics.median(column) for column in zip(*rows)]


def quiet(function, *arguments, **options):
    def call():
        with contextlib.redirect_stdout(io.StringIO()), numpy.errstate(all="ignore"):
            return function(*arguments, **options)
    return call


def family():
    print("""## Estimators, octaves of frequency data

Processor time of all threads together, so that a busy machine disturbs little.

| estimator | samples | ours [ms] | allantools [ms] | ratio |
|---|---:|---:|---:|---:|""")
    ratios = {}
    for name, sizes in SIZES.items():
        for size in sizes:
            data = rate_of(size)
            calls = [quiet(getattr(module, name), data, rate=100.0, data_type="freq")
                     for module in (tumble.compat.allantools, allantools)]
            mine, other, ratio = pairs(*calls, seconds=0.4)
            ratios[name, size] = ratio
            print(f"| {name} | {size} | {1e3 * mine:.3g} | {1e3 * other:.4g} | {ratio:.3g} |", flush=True)
    print()
    for size in sorted({size for _, size in ratios}):
        of_size = [ratio for (_, samples), ratio in ratios.items() if samples == size]
        print(f"* {size} samples: median ratio of {len(of_size)} estimators {statistics.median(of_size):.3g}, "
              f"smallest {min(of_size):.3g}")


def on(processors, call):
    """Real and processor time of one call, bound to so many processors."""
    os.sched_setaffinity(0, PROCESSORS[:processors])
    real, busy = time.perf_counter(), time.process_time()
    call()
    times = time.perf_counter() - real, time.process_time() - busy
    os.sched_setaffinity(0, PROCESSORS)
    return times


def hundred(repeats=5):
    """10^7 samples at 100 averaging times."""
    data = rate_of(10**7)
    taus = tumble.allan_deviation(data, 100.0, taus="log", points_per_decade=16).taus[:100]
    theirs = quiet(allantools.oadev, data, rate=100.0, data_type="freq", taus=taus)
    calls = {
        "tumble.allan_deviation, with noise types and limits": lambda: tumble.allan_deviation(data, 100.0, taus=taus),
        "tumble.compat.allantools.oadev": lambda: tumble.compat.allantools.oadev(data, 100.0, "freq", taus),
    }
    expected = theirs()[1]
    worst = max(numpy.max(numpy.abs(call()[1] / expected - 1.0)) for call in calls.values())
    rows = {(name, processors): [] for name in calls for processors in (1, 2)}
    for _ in range(repeats):
        other = on(2, theirs)
        for name, call in calls.items():
            rows[name, 1].append((on(1, call)[1], other[1]))
            rows[name, 2].append((on(2, call)[0], other[0]))
    print(f"""
## 10^7 samples, {len(taus)} averaging times, from a NumPy array

{repeats} rounds of all calls, one after the other. The deviations agree to {worst:.1e}. The median is that of the ratios; real time depends on
what else the machine does (load {os.getloadavg()[0]:.1f} at the end), so the ratio of the fastest runs is shown too.

| | ours [ms] | allantools [ms] | ratio, median | of the fastest |
|---|---:|---:|---:|---:|""")
    for (name, processors), pairs_of in rows.items():
        mine, other, ratio = (statistics.median(column) for column in zip(*((m, o, o / m) for m, o in pairs_of)))
        fastest = min(o for _, o in pairs_of) / min(m for m, _ in pairs_of)
        title = "one processor, processor time" if processors == 1 else "two processors, real time"
        print(f"| {name}: {title} | {1e3 * mine:.4g} | {1e3 * other:.4g} | {ratio:.3g} | {fastest:.3g} |", flush=True)


def session(module, frame):
    regions = module.ferraris_regions_from_df(frame)
    return module.FerrarisCalibration().compute(regions, 204.8, from_acc_unit="a.u.", from_gyr_unit="a.u.")


def calibration():
    frame = pandas.read_csv(SESSION).set_index("part")
    mine, other, ratio = pairs(lambda: session(tumble.compat.imucal, frame), lambda: session(imucal, frame), seconds=5.0)
    many = pandas.concat([frame.loc[[label]].sample(20_000, replace=True, random_state=1) for label in frame.index.unique()])
    rows = [(f"the published session, {len(frame)} rows", mine, other, ratio),
            (f"sections of 20 000 rows, {len(many)} in all",
             *pairs(lambda: session(tumble.compat.imucal, many), lambda: session(imucal, many), seconds=5.0))]
    cals = session(tumble.compat.imucal, frame), session(imucal, frame)
    acc, gyr = many.iloc[:, 1:4].to_numpy(), many.iloc[:, 4:7].to_numpy()
    rows.append((f"calibrate, {len(many)} rows", *pairs(*[lambda cal=cal: cal.calibrate(acc, gyr, "a.u.", "a.u.")
                                                         for cal in cals], seconds=3.0)))
    print("""
## imucal: from DataFrame to CalibrationInfo

Processor time, medians; numpy with one thread.

| | ours [ms] | imucal [ms] | ratio |
|---|---:|---:|---:|""")
    for title, mine, other, ratio in rows:
        print(f"| {title} | {1e3 * mine:.3g} | {1e3 * other:.4g} | {ratio:.3g} |")


def processor():
    names = [line.split(":")[1].strip() for line in open("/proc/cpuinfo", encoding="ascii") if line.startswith("model name")]
    return f"{names[0]}, {len(names)} cores"


def main():
    print("# tumble.compat beside the packages that it replaces\n")
    print(f"Machine: {processor()}, {platform.system()}; load {os.getloadavg()[0]:.1f} at the start. Python {platform.python_version()}, "
          f"numpy {numpy.__version__}, pandas {pandas.__version__}, allantools {allantools.__version__}, imucal {imucal.__version__}. "
          "Medians of pairs of calls in one process, one after the other, by `bench/compat.py`.\n")
    parts = {"family": family, "hundred": hundred, "imucal": calibration}
    for name, part in parts.items():
        if len(sys.argv) < 2 or name in sys.argv[1:]:
            part()


if __name__ == "__main__":
    main()
