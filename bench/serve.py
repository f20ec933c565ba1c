"""Speed of the workbench: pyramids built, first view, zoom, many clients; as a page for bench/results/serve.md.

    serve.py PROGRAM [--samples 100000000] [--output FILE]
    serve.py PROGRAM --live             50 clients on a run that goes on, alone

Needs numpy and h5py (script/packages-bench.txt). Recordings are made in a temporary folder: 9 bytes a sample.
"""

import argparse
import concurrent.futures
import http.client
import json
import os
import pathlib
import random
import re
import resource
import shutil
import socket
import statistics
import subprocess
import tempfile
import threading
import time
import urllib.parse

import h5py
import numpy


def write_recording(path, samples, deflated):
    """One gyro channel at 1 kHz, counts of a sensor as most are."""
    generator = numpy.random.default_rng(1)
    with h5py.File(path, "w") as file:
        options = {"chunks": (16384,), "compression": "gzip", "compression_opts": 3} if deflated else {}
        data = file.create_dataset("channels/gyro.x", (samples,), "f8", **options)
        data.attrs["unit"], data.attrs["rate"] = "deg/s", 1000.0
        for first in range(0, samples, 1 << 22):
            count = min(1 << 22, samples - first)
            data[first:first + count] = numpy.round(generator.normal(0.0, 20.0, count)) / 131.0


def build(program, recording, cache):
    """Seconds by the clock until the pyramid is there, of processors, and of the thread that builds without those that hash or unpack."""
    pathlib.Path(cache).mkdir()
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    process = subprocess.Popen([program, "serve", "--prepare", recording], env={**os.environ, "XDG_CACHE_HOME": cache, "XDG_STATE_HOME": cache})
    wall = own = None
    while process.poll() is None:
        if wall is None and list(pathlib.Path(cache).glob("tumble/*.of")):
            wall = time.monotonic() - begin
            own = processor_time(f"{process.pid}/task/{process.pid}")
            process.terminate()  # the checks that follow are those of `tumble inspect`
        time.sleep(0.002)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall or time.monotonic() - begin, own, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Server:
    def __init__(self, program, folder, cache):
        self.process = subprocess.Popen([program, "serve", folder, "--port", "0", "--no-token"], text=True, stdout=subprocess.PIPE,
                                        env={**os.environ, "XDG_CACHE_HOME": cache, "XDG_STATE_HOME": cache})
        self.process.stdout.readline()
        self.port = int(re.search(r":(\d+)/", self.process.stdout.readline())[1])

    def client(self):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)

    def memory(self):
        """(now, peak) [MB] that belongs to the server alone: pages of pyramids belong to the cache of the system."""
        text = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return tuple(int(re.search(rf"{name}:\s+(\d+)", text)[1]) / 1000 for name in ("RssAnon", "VmHWM"))


def ask(client, path):
    begin = time.monotonic()
    client.request("GET", path)
    response = client.getresponse()
    content = response.read()
    return response.status, len(content), 1e3 * (time.monotonic() - begin)


def view(file, first, last):
    return "/api/recording/view?" + urllib.parse.urlencode({"file": file, "from": first, "to": last, "pixels": 1200})


def random_span(generator, length):
    width = length * 10 ** (-5 * generator.random())
    first = (length - width) * generator.random()
    return first, first + width


def zooms(server, file, length, count, seed):
    generator, client, times, failures = random.Random(seed), server.client(), [], 0
    for _ in range(count):
        status, _, milliseconds = ask(client, view(file, *random_span(generator, length)))
        failures += status != 200
        times.append(milliseconds)
    client.close()
    return times, failures


def percentile(times, part):
    return sorted(times)[min(len(times) - 1, int(part * len(times)))]


def processor_time(process):
    """Seconds of user and system of a process so far."""
    fields = pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def free_port():
    with socket.socket() as door:
        door.bind(("127.0.0.1", 0))
        return door.getsockname()[1]


def begin_run(program, folder, speed):
    """A run on a virtual rig whose question is answered; it records 10 frames a second of its clock."""
    root = pathlib.Path(__file__).parent.parent
    shutil.copytree(root / "stations/frames", f"{folder}/frames")
    station = (root / "stations/gyro_scale_factor.toml").read_text()
    for port in ("21151", "21152", "21153"):
        station = station.replace(port, str(free_port()))
    pathlib.Path(folder, "station.toml").write_text(station)
    shutil.copy(root / "plans/gyro_scale_factor.toml", f"{folder}/plan.toml")
    process = subprocess.Popen([program, "run", "plan.toml", "--station", "station.toml", "--unit", "unit=7", "--operator", "bench",
                                "-o", "run", "--virtual-rig", "--speed", str(speed)], cwd=folder, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    answer = [program, "answer", f"{folder}/run", "done", "--operator", "bench"]
    while subprocess.run(answer, capture_output=True).returncode != 0:
        time.sleep(0.1)
    return process


def watch(port, until, ids):
    """Reads events until that time; the sequence numbers of what happened go into `ids`."""
    client = http.client.HTTPConnection("127.0.0.1", port, timeout=20)
    client.request("GET", "/api/station/run/events?run=run&after=0")
    stream, number = client.getresponse(), 0
    while time.monotonic() < until:
        line = stream.readline()
        if line.startswith(b"id: "):
            number = int(line[4:])
        elif line == b"event: happened\n":
            ids.append(number)
    client.close()


def scroll(port, until, times, failures):
    """Asks how far the run is, and zooms in what was recorded so far, four times a second."""
    client, generator = http.client.HTTPConnection("127.0.0.1", port, timeout=20), random.Random(len(times))
    while time.monotonic() < until:
        client.request("GET", "/api/recording?" + urllib.parse.urlencode({"file": "run/live.samples"}))
        recording = json.loads(client.getresponse().read())
        first, last = random_span(generator, recording["last"])
        status, _, milliseconds = ask(client, view("run/live.samples", first, last))
        times.append(milliseconds)
        failures.append(status != 200)
        time.sleep(0.25)
    client.close()


def live_run(program, clients=50, seconds=20.0, speed=5):
    """Lines of the table: what a run and the server cost, alone and with all these clients."""
    with tempfile.TemporaryDirectory() as folder:
        run = begin_run(program, folder, speed)
        before, begin = processor_time(run.pid), time.monotonic()
        time.sleep(seconds)
        alone = (processor_time(run.pid) - before) / (time.monotonic() - begin)
        server = Server(program, folder, f"{folder}/cache")
        seen, until = [[] for _ in range(clients)], time.monotonic() + seconds
        times, failures = [], []
        threads = [threading.Thread(target=watch, args=(server.port, until, ids)) for ids in seen]
        threads += [threading.Thread(target=scroll, args=(server.port, until, times, failures)) for _ in range(clients)]
        for thread in threads:
            thread.start()
        before, served, begin = processor_time(run.pid), processor_time(server.process.pid), time.monotonic()
        for thread in threads:
            thread.join()
        took = time.monotonic() - begin
        watched, served = (processor_time(run.pid) - before) / took, (processor_time(server.process.pid) - served) / took
        client = server.client()
        client.request("GET", "/api/station/run?run=run")
        state = json.loads(client.getresponse().read())
        if not state["alive"]:
            raise RuntimeError(f"the run has ended: {state['ending']} {state['ending_text']} {state['events'][-3:]}")
        shown = state["view"]
        view_frames = shown["frames"]
        client.request("GET", "/api/recording?" + urllib.parse.urlencode({"file": "run/live.samples"}))
        samples = max(channel["samples"] for channel in json.loads(client.getresponse().read())["channels"])
        memory = server.memory()[0]
        subprocess.run([program, "stop", f"{folder}/run"], capture_output=True)
        run.wait(60)
        client.request("GET", "/api/station/run?run=run")
        stored = [event["id"] for event in json.loads(client.getresponse().read())["events"] if event["kind"] != "clock"]
        missed = sum(ids != stored[:len(ids)] or not ids for ids in seen)
        server.process.terminate()
        server.process.wait()
    return [f"| {clients} clients on a run that goes on, {took:.0f} s, clock {speed} times as fast | {missed} clients missed an event or saw one twice; "
            f"the recorder has {shown['frames']} frames, {shown['lost']} lost, {shown['damaged']} damaged; the run takes {100 * watched:.1f} % of a processor, "
            f"{100 * alone:.1f} % before; the server {100 * served:.1f} % and {memory:.0f} MB | nothing lost |",
            f"| as many others that scroll in that run meanwhile, 4 zooms a second each | {sum(failures)} of {len(times)} failed, median "
            f"{statistics.median(times):.1f} ms, 95 % {percentile(times, 0.95):.1f} ms; {samples} samples can be seen when the recorder has "
            f"{view_frames} frames | nothing lost |"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--samples", type=int, default=100_000_000)
    parser.add_argument("--output")
    parser.add_argument("--live", action="store_true")
    arguments = parser.parse_args()
    if arguments.live:
        print("\n".join(live_run(os.path.abspath(arguments.program))), f"\n\nLoad: {os.getloadavg()[0]:.1f}")
        return
    lines = ["# The workbench: `bench/serve.py`", "",
             f"{os.cpu_count()} processors, load {os.getloadavg()[0]:.1f} at the start; one channel of float64 at 1 kHz. "
             "The time of a pyramid is that until it can be looked at; the SHA-256 of the recording is worked out on another processor meanwhile. "
             "A view has 1200 pixels and is timed from the request to its last byte, over loopback.", "",
             "| what | figure | asked |", "|---|---|---|"]
    with tempfile.TemporaryDirectory() as folder:
        data = pathlib.Path(folder, "data")
        data.mkdir()
        for name, samples, deflated, asked in (("plain", arguments.samples, False, "1.5 GB/s"),
                                               ("deflated", arguments.samples // 5, True, "0.4 GB/s")):
            path = str(data / f"{name}.h5")
            write_recording(path, samples, deflated)
            with open(path, "rb") as file:
                while file.read(1 << 24):
                    pass
            wall, own, cpu = build(arguments.program, path, f"{folder}/{name}")
            size = 8e-9 * samples
            lines.append(f"| pyramid of {samples:.0e} samples, {name} HDF5 | {size / wall:.2f} GB/s by the clock ({wall:.2f} s), "
                         f"{size / cpu:.2f} GB/s of one processor with the SHA-256" +
                         (f", {size / own:.2f} GB/s of the thread that builds" if own and not deflated else "") + f" | {asked} |")
        subprocess.run([arguments.program, "serve", "--prepare", str(data / "plain.h5")], check=True,
                       env={**os.environ, "XDG_CACHE_HOME": f"{folder}/plain"})
        length = arguments.samples / 1000.0
        server = Server(arguments.program, str(data), f"{folder}/plain")
        status, size, first = ask(server.client(), view("plain.h5", 0, length))
        lines.append(f"| first view of {arguments.samples:.0e} samples, server just started | {first:.1f} ms, {size / 1000:.0f} kB (status {status}) | 1000 ms |")
        times, failures = zooms(server, "plain.h5", length, 400, 1)
        lines.append(f"| zoom to a random span of it, 5 decades | median {statistics.median(times):.2f} ms, 95 % {percentile(times, 0.95):.1f} ms, "
                     f"{failures} failures | 50 ms |")
        client, generator = server.client(), random.Random(3)
        times = [ask(client, "/api/recording/statistics?" + urllib.parse.urlencode(dict(zip(("file", "from", "to"), ("plain.h5", *random_span(generator, length))))))[2]
                 for _ in range(200)]
        lines.append(f"| exact statistics of a random span | median {statistics.median(times):.2f} ms, 95 % {percentile(times, 0.95):.1f} ms | |")
        server.process.terminate()
        server.process.wait()

        small = arguments.samples // 10
        write_recording(str(data / "small.h5"), small, False)
        subprocess.run([arguments.program, "serve", "--prepare", str(data / "small.h5")], check=True,
                       env={**os.environ, "XDG_CACHE_HOME": f"{folder}/plain"})
        server = Server(arguments.program, str(data), f"{folder}/plain")
        with concurrent.futures.ThreadPoolExecutor(50) as pool:
            results = list(pool.map(lambda seed: zooms(server, "small.h5", small / 1000.0, 40, seed), range(50)))
        times = [one for some, _ in results for one in some]
        own, peak = server.memory()
        lines.append(f"| 50 clients, 40 zooms each, {small:.0e} samples | {sum(failed for _, failed in results)} failures, median "
                     f"{statistics.median(times):.0f} ms, 95 % {percentile(times, 0.95):.0f} ms; the server holds {own:.0f} MB of its own, "
                     f"{peak:.0f} MB at most with mapped files | no error, memory bounded |")
        server.process.terminate()
        server.process.wait()
    lines += live_run(os.path.abspath(arguments.program))
    lines.append("")
    lines.append('"Of one processor" divides by the processor time of all threads, with the start of the program and as much of the SHA-256 as '
                 'was done by then; "of the thread that builds" leaves out the threads that hash. Deflated chunks are unpacked on all processors.')
    lines.append("")
    lines.append(f"Load at the end: {os.getloadavg()[0]:.1f}. The zoom round trip of the browser is measured by `script/browser`.")
    text = "\n".join(lines) + "\n"
    print(text)
    if arguments.output:
        pathlib.Path(arguments.output).write_text(text)


if __name__ == "__main__":
    main()
