#!/usr/bin/env python3
"""Measures tumble.fleet on this machine and prints a Markdown page.

usage: PYTHONPATH=build/dev/python build/venv/bin/python bench/fleet.py [PART...] [--units 500] [--data FOLDER] > bench/results/fleet.md
PART: efficiency, kills, scheduler, many, record; without any, the first three. `many` takes an hour of processor. Processor times are those of all processes of a run; wall
times are figures on a quiet machine only, so the page says its load. `record` writes 16 GB into the folder of the data (--samples 1e9).
"""

import argparse
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import numpy

import tumble
from tumble import fleet

TREE = pathlib.Path(__file__).resolve().parent.parent
PLAN = TREE / "plans/imu_turntable_short.toml"
NOISE_SAMPLES, NOISE_RATE = 360_000, 100.0  # an hour
CORES = len(os.sched_getaffinity(0))

RUN = """
import json, os, resource, sys, time
from tumble import fleet
plan, data, out, workers = sys.argv[1:5]
begin = time.monotonic()
made = fleet.run(plan, data, out, executor="serial" if workers == "0" else "processes", workers=int(workers) or None)
wall = time.monotonic() - begin
used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(json.dumps({"wall": wall, "processor": sum(u.ru_utime + u.ru_stime for u in used), "status": str(made.status())}))
"""


def say(text):
    print(text, file=sys.stderr, flush=True)


def turntable_units(folder, count):
    """Simulated records of the plan, one a unit."""
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(1, count + 1):
        path = folder / f"imu-{seed:04}.h5"
        if not path.exists():
            tumble.simulate(PLAN, seed=seed).save(path)
    for extra in sorted(folder.iterdir())[count:]:
        extra.unlink()
    return folder


def noise_units(folder, count, samples=NOISE_SAMPLES):
    """White noise and a random walk of a gyro, an hour at 100 Hz."""
    folder.mkdir(parents=True, exist_ok=True)
    for seed in range(1, count + 1):
        path = folder / f"gyro-{seed:04}.h5"
        if not path.exists():
            rng = numpy.random.default_rng(seed)
            rate = rng.normal(0.0, 0.02, samples) + numpy.cumsum(rng.normal(0.0, 1e-5, samples))
            tumble.from_arrays({"gyro.x": (rate, "deg/s")}, rate=NOISE_RATE).save(path)
    return folder


def measured(plan, data, out, workers):
    shutil.rmtree(out, ignore_errors=True)
    words = [sys.executable, "-c", RUN, str(plan), str(data), str(out), str(workers)]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.splitlines()[-1])


def busy_share(out, workers):
    """Share of the time between the first and the last task in which the workers were at work."""
    lines = [json.loads(line) for log in (out / "log").glob("work-*.jsonl") for line in log.read_text().splitlines()]
    begins = {line["key"]: line["time"] for line in lines if line["work"] == "begins"}
    ends = {line["key"]: line["time"] for line in lines if line["work"] == "ends"}
    spent = sum(ends[key] - begins[key] for key in ends)
    return spent / (workers * (max(ends.values()) - min(begins.values())))


def efficiency(data, work, count):
    rows = []
    kinds = [
        ("imu_turntable_short", PLAN, turntable_units(data / "imu", count)),
        ("allan_noise, 360 000 samples", "allan_noise", noise_units(data / "noise", count)),
    ]
    for name, plan, folder in kinds:
        say(f"efficiency: {name}")
        one, two = measured(plan, folder, work / "one", 1), measured(plan, folder, work / "two", 2)
        rows.append((name, one, two, busy_share(work / "two", 2)))
    print(f"""## One worker and two, {count} units of each kind

Load of the machine at the end: {os.getloadavg()[0]:.1f} on {CORES} processors. Efficiency is the rate of two workers over that of one, doubled: by wall
time (a figure where nothing else runs), and by processor time, which other programs do not change much: what a unit costs with one worker
over what it costs with two. `at work` is the share of their time in which the two workers reduced recordings, the rest is waiting.

| units | 1 worker: wall, processor [s] | 2 workers: wall, processor [s] | core-seconds a unit | at work | efficiency: wall, processor |
|---|---:|---:|---:|---:|---:|""")
    for name, one, two, busy in rows:
        print(
            f"| {name} | {one['wall']:.1f}, {one['processor']:.1f} | {two['wall']:.1f}, {two['processor']:.1f} | "
            f"{two['processor'] / count:.3f} | {100 * busy:.0f} % | {50 * one['wall'] / two['wall']:.0f} %, "
            f"{100 * one['processor'] / two['processor']:.0f} % |"
        )
    print()


def computed(out):
    keys = []
    for log in (out / "log").glob("work-*.jsonl"):
        keys += [line["key"] for line in map(json.loads, log.read_text().splitlines()) if line["work"] == "ends"]
    return keys


def begun(out):
    keys = []
    for log in (out / "log").glob("work-*.jsonl"):
        keys += [line["key"] for line in map(json.loads, log.read_text().splitlines()) if line["work"] == "begins"]
    return keys


def children(process):
    """The workers: each was started by a thread of its own."""
    texts = [path.read_text() for path in pathlib.Path(f"/proc/{process}/task").glob("*/children")]
    return [int(word) for text in texts for word in text.split()]


def kills(data, work, worker_kills=20, driver_kills=5):
    folder = noise_units(data / "short", 100, 20_000)
    shutil.rmtree(work / "serial", ignore_errors=True)
    serial = fleet.run("allan_noise", folder, work / "serial", executor="serial").table()
    random.seed(7)
    whole = measured("allan_noise", folder, work / "timed", 2)["wall"]
    words = [sys.executable, "-c", RUN, "allan_noise", str(folder), str(work / "killed"), "2"]
    equal = twice = lost = hit = 0
    for number in range(worker_kills):
        say(f"kill of a worker {number + 1} of {worker_kills}")
        shutil.rmtree(work / "killed", ignore_errors=True)
        driver = subprocess.Popen(words, stdout=subprocess.DEVNULL)
        time.sleep(random.uniform(0.1, 0.95) * whole)
        try:
            os.kill(random.choice(children(driver.pid)), signal.SIGKILL)
            hit += 1
        except (IndexError, OSError):
            pass  # the run had ended, or had not begun
        driver.wait()
        made = fleet.Fleet(work / "killed")
        equal += made.table().equals(serial)
        keys = computed(work / "killed")
        twice += len(keys) - len(set(keys))
        lost = max(lost, len(begun(work / "killed")) - len(keys))
    driver_equal = driver_twice = again = 0
    for number in range(driver_kills):
        say(f"kill of the driver {number + 1} of {driver_kills}")
        shutil.rmtree(work / "killed", ignore_errors=True)
        driver = subprocess.Popen(words, stdout=subprocess.DEVNULL)
        time.sleep(random.uniform(0.2, 0.9) * whole)
        driver.send_signal(signal.SIGKILL)
        driver.wait()
        time.sleep(1.0)  # its workers end what they had begun
        made = fleet.run("allan_noise", folder, work / "killed", workers=2)
        driver_equal += made.table().equals(serial)
        keys = computed(work / "killed")
        driver_twice += len(keys) - len(set(keys))
        again = max(again, len(begun(work / "killed")) - len(keys))
    print(f"""## SIGKILL at random instants

100 noise records, 2 workers; a run takes {whole:.1f} s here.

| killed | times | table equals the serial one | results computed twice | tasks begun again, at most in a run |
|---|---:|---:|---:|---:|
| a worker | {hit} of {worker_kills} | {equal} of {worker_kills} | {twice} | {lost} |
| the driver, and the run repeated | {driver_kills} | {driver_equal} of {driver_kills} | {driver_twice} | {again} |
""")


def processor_time(process):
    words = pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def nothing(number):
    return number


def scheduler(work, tasks=100_000, workers=8):
    import distributed

    from tumble.fleet._engines import Dask

    folder = work / "dask"
    folder.mkdir(exist_ok=True)
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    python = [
        sys.executable,
        "-m",
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--scheduler-file",
        str(file),
    ]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": folder}
    master = subprocess.Popen(python, **quiet)
    hands = subprocess.Popen(
        [
            sys.executable,
            "-m",
            "distributed.cli.dask_worker",
            "--scheduler-file",
            str(file),
            "--nworkers",
            str(workers),
            "--nthreads",
            "1",
            "--no-dashboard",
        ],
        **quiet,
    )
    try:
        with distributed.Client(scheduler_file=str(file), timeout=60) as client:
            client.wait_for_workers(workers, timeout=120)
            say("scheduler: map")
            before, begin = processor_time(master.pid), time.monotonic()
            total = 0
            for first in range(0, tasks, 10_000):
                total += len(client.gather(client.map(nothing, range(first, min(tasks, first + 10_000)), pure=False)))
            mapped, wall = processor_time(master.pid) - before, time.monotonic() - begin
            assert total == tasks
            say("scheduler: as the fleet submits")
            few = tasks // 10
            engine = Dask(client)
            before, mine, begin = processor_time(master.pid), time.process_time(), time.monotonic()
            waiting = set()
            from concurrent.futures import FIRST_COMPLETED, wait

            for number in range(few):
                waiting.add(engine.submit(nothing, number))
                if len(waiting) >= 2 * workers:
                    waiting = wait(waiting, return_when=FIRST_COMPLETED)[1]
            wait(waiting)
            single, driver, single_wall = (
                processor_time(master.pid) - before,
                time.process_time() - mine,
                time.monotonic() - begin,
            )
    finally:
        hands.terminate()
        master.terminate()
        hands.wait()
        master.wait()
    cost = max(single, driver) / few
    print(f"""## The scheduler of Dask

A scheduler in a process of its own, {workers} worker processes on {CORES} processors, empty tasks. Load {os.getloadavg()[0]:.1f}.

| | tasks | processor time of the scheduler a task [ms] | of the driver [ms] | wall [s] |
|---|---:|---:|---:|---:|
| `client.map` in tens of thousands | {tasks} | {1e3 * mapped / tasks:.3f} | | {wall:.0f} |
| one by one, two in flight a worker, as the fleet submits | {few} | {1e3 * single / few:.3f} | {1e3 * driver / few:.3f} | {single_wall:.0f} |

Scheduler and driver each use one processor, so the slower of them limits at 1/{1e3 * cost:.2f} ms = {1 / cost:.0f} tasks a second. Workers that take
t seconds a task are kept busy up to t/{1e3 * cost:.2f} ms of them:

| task | seconds | workers |
|---|---:|---:|
| a noise record of an hour | 0.05 | {0.05 / cost:.0f} |
| a unit of imu_turntable_short | 0.34 | {0.34 / cost:.0f} |
| a record of a day at 1 kHz | 3 | {3 / cost:.0f} |
""")


MANY = """
import json, resource, sys, time
from tumble import fleet
begin, marks = time.monotonic(), []
def note(done, what):
    if done >= (len(marks) + 1) / 10 - 1e-9:
        with open("/proc/self/statm") as file:
            marks.append([time.monotonic() - begin, int(file.read().split()[1]) * resource.getpagesize() / 2**20])
made = fleet.run("allan_noise", sys.argv[1], sys.argv[2], workers=2, progress=note)
status = made.status()
again = time.monotonic()
fleet.run("allan_noise", sys.argv[1], sys.argv[2], workers=2)
used = resource.getrusage(resource.RUSAGE_SELF)
print(json.dumps({"marks": marks, "status": str(status), "again": time.monotonic() - again,
                  "driver": used.ru_utime + used.ru_stime, "peak": used.ru_maxrss / 1024}))
"""


def many(data, work, count):
    """So many recordings of 300 samples that what grows with them is seen."""
    folder = data / "many"
    folder.mkdir(parents=True, exist_ok=True)
    rng = numpy.random.default_rng(5)
    for number in range(count):
        path = folder / f"u{number:07}.csv"
        if not path.exists():
            lines = "\n".join(f"{k / 100:.2f},{value:.5f}" for k, value in enumerate(rng.normal(0.0, 0.02, 300)))
            path.write_text(f"time [s],gyro.x [deg/s]\n{lines}\n")
    shutil.rmtree(work / "many", ignore_errors=True)
    say("many: run")
    done = subprocess.run(
        [sys.executable, "-c", MANY, str(folder), str(work / "many")], check=True, capture_output=True, text=True
    )
    found = json.loads(done.stdout.splitlines()[-1])
    print(f"""## {count} recordings of 300 samples

2 workers, load {os.getloadavg()[0]:.1f} at the end. The driver took {1e3 * found["driver"] / count:.2f} ms of processor time a recording, and {found["peak"]:.0f} MB at most; a second
run that finds everything done takes {found["again"]:.0f} s. {found["status"]}.

| done | seconds | memory of the driver [MB] |
|---|---:|---:|""")
    for part, (seconds, memory) in enumerate(found["marks"], 1):
        print(f"| {part * count // 10} | {seconds:.0f} | {memory:.0f} |")
    print()


RECORD = """
import json, resource, sys, time
import tumble
from tumble import fleet
what, source, out, target, workers = sys.argv[1:6]
begin = time.monotonic()
if what == "one":
    result = tumble.identify("allan_noise", source, memory_limit=1e6)
else:
    result = fleet.record("allan_noise", source, out, workers=int(workers))
result.save(target)
used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(json.dumps([time.monotonic() - begin, sum(u.ru_utime + u.ru_stime for u in used), max(u.ru_maxrss for u in used) / 1024]))
"""


def record(data, work, samples, files=100, rate=1000.0):
    import h5py

    folder = data / "record"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    rng, walk, each = numpy.random.default_rng(3), 0.0, samples // files
    whole = folder / "whole.h5"
    say("record: files")
    parts = folder / "parts"
    parts.mkdir()
    steps = []
    for number in range(files):
        rate_walk = walk + numpy.cumsum(rng.normal(0.0, 3e-6 / numpy.sqrt(rate), each))
        walk = rate_walk[-1]
        values = rng.normal(0.0, 2e-4 * numpy.sqrt(rate), each) + rate_walk
        part = parts / f"{number:03}.h5"
        tumble.from_arrays({"gyro.x": (values, "rad/s")}, rate=rate, start=number * each / rate).save(part)
        steps.append(part)
        if number == 0:
            shutil.copy(part, whole)
            with h5py.File(whole, "r+") as file:
                name = dataset_of(file)
                copied = file[name]
                attributes, chunks = dict(copied.attrs), copied.chunks or (65536,)
                del file[name]
                grown = file.create_dataset(name, shape=(each * files,), dtype="f8", chunks=chunks)
                for key, value in attributes.items():
                    grown.attrs[key] = value
        with h5py.File(whole, "r+") as file:
            file[dataset_of(file)][number * each : (number + 1) * each] = values
    results = {}
    for what, source in (("one", whole), ("many", parts)):
        say(f"record: {what}")
        words = [
            sys.executable,
            "-c",
            RECORD,
            what,
            str(source),
            str(work / "record.fleet"),
            str(work / f"{what}.json"),
            "2",
        ]
        shutil.rmtree(work / "record.fleet", ignore_errors=True)
        results[what] = json.loads(
            subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()[-1]
        )
    one, many = tumble.load_result(work / "one.json"), tumble.load_result(work / "many.json")
    apart = max(abs(numpy.array(many.values) / one.values - 1.0))
    sds = max(abs(a.sd / b.sd - 1.0) for a, b in zip(many.parameters.values(), one.parameters.values(), strict=True))
    curve = max(abs(many.curves[0].y.values / one.curves[0].y.values - 1.0))
    size = sum(path.stat().st_size for path in (work / "record.fleet/parts").iterdir()) / files / 1e6
    shutil.rmtree(folder)
    print(f"""## One record in many files

{samples:.0e} samples at {rate:.0f} Hz in {files} files ({8e-9 * samples:.0f} GB), `fleet.record` with 2 workers, and `identify` of the same samples in one file, block after block. Load
{os.getloadavg()[0]:.1f}.

| | wall [s] | processor [s] | peak memory of a process [MB] |
|---|---:|---:|---:|
| one machine, one file | {results["one"][0]:.0f} | {results["one"][1]:.1f} | {results["one"][2]:.0f} |
| 2 workers, {files} files | {results["many"][0]:.0f} | {results["many"][1]:.1f} | {results["many"][2]:.0f} |

Greatest relative difference: parameters {apart:.1e}, their standard uncertainties {sds:.1e}, the Allan deviation {curve:.1e}. A part takes {size:.2f} MB.
""")


def dataset_of(file):
    """The dataset of the samples: the largest one."""
    import h5py

    found = []
    file.visititems(lambda name, item: found.append((item.size, name)) if isinstance(item, h5py.Dataset) else None)
    return max(found)[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", default=[])
    parser.add_argument("--units", type=int, default=500)
    parser.add_argument("--recordings", type=int, default=100_000)
    parser.add_argument("--samples", type=float, default=1e9)
    parser.add_argument("--tasks", type=int, default=100_000)
    parser.add_argument("--data", type=pathlib.Path)
    given = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    print("# Fleets\n\nOne run of `bench/fleet.py`; the machine may be busy, and the page says how much.\n")
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        data = given.data or work / "data"
        for part in given.parts or ["efficiency", "kills", "scheduler"]:
            if part == "efficiency":
                efficiency(data, work, given.units)
            elif part == "kills":
                kills(data, work)
            elif part == "scheduler":
                scheduler(work, given.tasks)
            elif part == "many":
                many(data, work, given.recordings)
            elif part == "record":
                record(data, work, int(given.samples))
            else:
                parser.error(f"{part}: one of efficiency, kills, scheduler, many, record is expected")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
