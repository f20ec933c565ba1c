"""CSV to channels: Tumble against pandas' C reader, on the same file and in the same run.

usage: csv_reader.py PROGRAM [--rows N] [--rounds N] [--output FILE.md]

PROGRAM is build/release/bench/bench_csv_reader. Both read alternately, each time in a fresh process, and
time only the reading. The values are held against pandas' float_precision='round_trip', bit by bit.
Needs python3-pandas.
"""

import argparse
import os
import platform
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

PANDAS = """
import sys, time, pandas
wall, cpu = time.perf_counter(), time.process_time()
table = pandas.read_csv(sys.argv[1])
print(time.perf_counter() - wall, time.process_time() - cpu)
"""


def make(path, rows):
    """Time and six axes: gyros with 9 decimals, accelerometers with all 16 or 17 digits."""
    import numpy
    random = numpy.random.default_rng(7)
    with open(path, "w") as file:
        file.write("time[s],gyro.x[deg/h],gyro.y[deg/h],gyro.z[deg/h],acc.x[m/s^2],acc.y[m/s^2],acc.z[m/s^2]\n")
        for first in range(0, rows, 100000):
            k = numpy.arange(first, min(rows, first + 100000))
            gyro = random.normal(0, 15, (len(k), 3)).tolist()
            acc = (random.normal(0, 0.01, (len(k), 3)) + [0, 0, 9.8]).tolist()
            file.writelines("%.4f,%.9f,%.9f,%.9f,%r,%r,%r\n" % (t, *g, *a)
                            for t, g, a in zip((k / 400).tolist(), gyro, acc))


def run(command):
    return [float(word) for word in subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()]


def check(program, path, dump):
    """Every sample equals the correctly rounded decimal, times the same factor."""
    import numpy
    import pandas
    run([program, path, "table", dump])
    table = pandas.read_csv(path, float_precision="round_trip").to_numpy()[:, 1:]
    ours = numpy.fromfile(dump).reshape(6, -1).T
    factor = numpy.array([numpy.pi / 180 / 3600] * 3 + [1.0] * 3)
    # The factor of deg/h is recovered from the first sample, as its rounding is the library's business.
    factor[:3] = [min((f, numpy.nextafter(f, 1), numpy.nextafter(f, 0)),
                      key=lambda c: numpy.count_nonzero(table[:, i] * c != ours[:, i])) for i, f in
                  enumerate(factor[:3])]
    return table.shape[0], int(numpy.count_nonzero(table * factor != ours))


def processor():
    for line in open("/proc/cpuinfo"):
        if line.startswith("model name"):
            return line.split(":")[1].strip()
    return platform.processor()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--rows", type=int, default=1850000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--output")
    options = parser.parse_args()
    import pandas
    with tempfile.TemporaryDirectory() as folder:
        path, dump = str(Path(folder) / "bench.csv"), str(Path(folder) / "dump")
        make(path, options.rows)
        size = os.path.getsize(path) / 1e6
        rows, different = check(options.program, path, dump)
        times = {"pandas": [], "table": [], "file": []}
        for _ in range(options.rounds):
            times["pandas"].append(run([sys.executable, "-c", PANDAS, path]))
            for mode in ("table", "file"):
                times[mode].append(run([options.program, path, mode]))
    wall = {name: statistics.median(t[0] for t in values) for name, values in times.items()}
    cpu = {name: statistics.median(t[1] for t in values) for name, values in times.items()}
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout.splitlines()[0]
    lines = [
        "# CSV to channels", "",
        f"{rows} rows x 7 columns, {size:.0f} MB (time, three axes with 9 decimals, three with 16 or 17 digits). "
        f"{options.rounds} rounds, each reader in a fresh process in turn; medians. "
        f"Load of the machine at the end: {os.getloadavg()[0]:.1f}.", "",
        "| reader | wall [s] | processor [s] | MB/s of processor time | pandas / this, wall | processor |",
        "|---|---|---|---|---|---|"]
    names = {"pandas": "pandas.read_csv (engine 'c')", "table": "Tumble, one thread, no checksum",
             "file": "Tumble as users read: SHA-256 in a second thread"}
    for key, name in names.items():
        lines.append(f"| {name} | {wall[key]:.3f} | {cpu[key]:.3f} | {size / cpu[key]:.0f} | "
                     f"{wall['pandas'] / wall[key]:.2f} | {cpu['pandas'] / cpu[key]:.2f} |")
    lines += ["", f"Samples that differ from float_precision='round_trip': {different} of {rows * 6}.", "",
              f"{processor()}, {os.cpu_count()} cores; {compiler} -O3 -DNDEBUG (release preset); pandas {pandas.__version__}, "
              f"Python {platform.python_version()}."]
    text = "\n".join(lines) + "\n"
    print(text)
    if options.output:
        Path(options.output).write_text(text)
    return 0 if different == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
