"""Runs a program of GoogleTest in a few processes that share its tests.

    run_shards.py PROGRAM [--without REGEX] [--only REGEX] [--jobs N] [--tests-a-process N] [--most-minutes M]
    run_shards.py --self-test

ctest starts a process for each test. With sanitisers the start takes longer than most tests, so that they are run here: each
process takes some tests of different suites. What a failed test printed is shown, and which test ran when a process ended early;
the tests behind it are run in another process. The last line says how many passed and failed; exit status 1 when any failed.
REGEX is searched in Suite.Name, as ctest does. After M minutes no other process begins: the tests that are left are counted and
named, and are no failure. Which these are changes from commit to commit: the order of the processes is drawn from the commit.
"""

import argparse
import concurrent.futures
import os
import random
import re
import subprocess
import sys
import tempfile
import time


def listed(program):
    """Names of the tests that the program has."""
    out = subprocess.run([program, "--gtest_list_tests"], check=True, capture_output=True, text=True)
    suite, names = "", []
    for line in out.stdout.splitlines():
        word = line.split("#")[0].rstrip()
        if word.endswith(".") and not line.startswith(" "):
            suite = word
        elif line.startswith("  "):
            names.append(suite + word.strip())
    return names


def shares(names, size):
    """The names in shares of about `size`, neighbours in different ones: tests of one suite take about the same time."""
    count = max(1, -(-len(names) // size))
    return [names[first::count] for first in range(count)]


def outcomes(text, names):
    """Tests that passed, that failed, and those that the process did not come to. One that began and did not end has failed."""
    passed = set(re.findall(r"^\[       OK \] (\S+)", text, re.M))
    skipped = set(re.findall(r"^\[  SKIPPED \] (\S+\.\S+)", text, re.M))
    failed = set(re.findall(r"^\[  FAILED  \] ([^\s,]+\.[^\s,]+)", text, re.M))
    begun = set(re.findall(r"^\[ RUN      \] (\S+)", text, re.M))
    failed |= begun - passed - skipped
    return passed, skipped, failed, [name for name in names if name not in begun]


def ended(program, names, most_seconds):
    """What a process of these tests printed, and its exit status; one that takes too long is killed."""
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+", errors="replace") as printed:
        try:
            status = subprocess.run([program, f"--gtest_filter={':'.join(names)}"], cwd=folder, stdin=subprocess.DEVNULL, stdout=printed,
                                    stderr=subprocess.STDOUT, timeout=most_seconds).returncode
        except subprocess.TimeoutExpired:
            status = f"none, killed after {most_seconds} s"
        printed.seek(0)
        return printed.read(), status


def run(program, names, most_seconds=900):
    """Runs these tests until each has begun; the texts of processes in which something failed, and the seconds of each test."""
    passed, skipped, failed, texts, seconds = set(), set(), set(), [], {}
    while names:
        text, status = ended(program, names, most_seconds)
        p, s, f, left = outcomes(text, names)
        seconds |= {name: int(ms) / 1e3 for name, ms in re.findall(r"^\[[ A-Z]{10}\] (\S+?)(?:, where .*)? \((\d+) ms\)$", text, re.M)}
        if status != 0 and not f:  # leaks are told when all has run
            f = {f"process of {names[0]} and {len(names) - 1} others: exit status {status}"}
        passed, skipped, failed = passed | p, skipped | s, failed | f
        if f:
            texts.append(text)
        if len(left) == len(names):
            failed.add(f"{names[0]}: the process ended before its first test")
            break
        names = left
    return passed, skipped, failed, texts, seconds


def drawn(all_shares):
    """The shares in an order that another commit does not have."""
    commit = subprocess.run(["git", "rev-parse", "HEAD"], capture_output=True, text=True).stdout
    random.Random(commit).shuffle(all_shares)
    return all_shares


def run_all(program, names, jobs, size, end=float("inf")):
    passed, skipped, failed, seconds, left = set(), set(), set(), {}, []

    def in_time(share):
        if time.monotonic() < end:
            return run(program, share)
        left.extend(share)
        return set(), set(), set(), [], {}

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for p, s, f, texts, of_each in pool.map(in_time, drawn(shares(names, size))):
            passed, skipped, failed, seconds = passed | p, skipped | s, failed | f, seconds | of_each
            for text in texts:
                print(text[-20000:], flush=True)
    print("the slowest, of {:.0f} s in all: ".format(sum(seconds.values())) +
          ", ".join(f"{name} {seconds[name]:.0f} s" for name in sorted(seconds, key=seconds.get, reverse=True)[:20]))
    for name in sorted(skipped):
        print(f"skipped  {name}")
    for name in sorted(failed):
        print(f"FAILED   {name}")
    if left:
        print(f"not run, since the time had ended: {len(left)} of {len(names)}: " + " ".join(sorted(left)))
    print(f"{len(passed)} passed, {len(failed)} failed, {len(skipped)} skipped, {len(left)} not run")
    return 1 if failed or not (passed or left) else 0


SAMPLE = """#!/usr/bin/env python3
import os, sys, time
names = ["A.Good", "A.Bad", "B.Dies", "B.Skips", "B.Last", "B.Hangs"]
asked = sys.argv[-1].partition("=")[2]
if "--gtest_list_tests" in sys.argv:
    print("A.\\n  Good\\n  Bad\\nB.\\n  Dies  # GetParam() = 1\\n  Skips\\n  Last")
    sys.exit()
for name in [n for n in names if n in asked.split(":")]:
    print("[ RUN      ] " + name, flush=True)
    if name == "B.Dies":
        os.abort()
    if name == "B.Hangs":
        time.sleep(60)
    end = {"A.Bad": "[  FAILED  ] A.Bad (0 ms)", "B.Skips": "[  SKIPPED ] B.Skips (0 ms)"}
    print(end.get(name, f"[       OK ] {name} (0 ms)"), flush=True)
sys.exit("A.Bad" in asked)
"""


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        program = os.path.join(folder, "program")
        with open(program, "w") as file:
            file.write(SAMPLE)
        os.chmod(program, 0o755)
        names = listed(program)
        assert names == ["A.Good", "A.Bad", "B.Dies", "B.Skips", "B.Last"], names
        passed, skipped, failed, texts, seconds = run(program, names)
        assert passed == {"A.Good", "B.Last"} and skipped == {"B.Skips"} and failed == {"A.Bad", "B.Dies"}, (passed, skipped, failed)
        assert set(seconds) == {"A.Good", "A.Bad", "B.Skips", "B.Last"}, seconds
        assert run(program, ["B.Hangs", "A.Good"], 2)[:3] == ({"A.Good"}, set(), {"B.Hangs"})
        assert run_all(program, ["A.Good"], 1, 1) == 0 and run_all(program, ["A.Good", "B.Dies"], 1, 1) == 1
        assert run_all(program, ["A.Good"], 1, 1, end=0.0) == 0 and run_all(program, [], 1, 1) == 1
        assert len(texts) == 1 and "[ RUN      ] B.Dies" in texts[0]
        assert shares(names, 2) == [["A.Good", "B.Skips"], ["A.Bad", "B.Last"], ["B.Dies"]]
    print("run_shards.py finds what passed, failed, was skipped and ended its process")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?")
    parser.add_argument("--without", default="")
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--tests-a-process", type=int, default=40)
    parser.add_argument("--most-minutes", type=float, default=float("inf"))
    parser.add_argument("--self-test", action="store_true")
    asked = parser.parse_args()
    if asked.self_test:
        return self_test()
    program = os.path.abspath(asked.program)
    names = [name for name in listed(program)
             if re.search(asked.only, name) and not (asked.without and re.search(asked.without, name))]
    return run_all(program, names, asked.jobs, asked.tests_a_process, time.monotonic() + 60.0 * asked.most_minutes)


if __name__ == "__main__":
    sys.exit(main())
