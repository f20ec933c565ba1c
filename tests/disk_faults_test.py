"""Every call that changes the disk fails once, in each verb that writes a file: the program ends with another status than 0,
or the file is whole. Never is there half a file under its name.

    disk_faults_test.py TUMBLE REPOSITORY SHIM
"""

import itertools
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

TUMBLE, SOURCE, SHIM = map(os.path.abspath, sys.argv[1:4])
MOST_CALLS = 2000  # of a verb: far more than any makes


def run(arguments, folder, environment=None):
    return subprocess.run([TUMBLE, *arguments], cwd=folder, env={**os.environ, **(environment or {})}, timeout=120,
                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def short_plan(folder):
    """A plan of static_bias with runs of a few seconds."""
    text = pathlib.Path(SOURCE, "plans/static_bias.toml").read_text()
    lines = []
    for line in text.splitlines():
        lines.append('duration = "40 s"' if line.strip().startswith("duration") else line)
    pathlib.Path(folder, "plan.toml").write_text("\n".join(lines) + "\n")


def prepared(folder):
    short_plan(folder)
    for name in ("lab.toml", "logo.svg"):
        shutil.copy(pathlib.Path(SOURCE, "examples", name), folder)
    for arguments in (["simulate", "plan.toml", "-o", "data.h5", "--seed", "3"],
                      ["identify", "plan.toml", "data.h5", "-o", "result.json"]):
        done = run(arguments, folder)
        assert done.returncode == 0, (arguments, done.stderr)


def writers(folder):
    """Arguments of each verb that writes a file, and the name of that file."""
    catalogue = json.loads(subprocess.run([TUMBLE, "list", "--json"], capture_output=True, text=True, check=True).stdout)
    formats = [one for one in catalogue["formats"] if one.get("writes")]
    assert formats, "the catalogue lists formats that can be written"
    for one in formats:
        name = "out" + one["extensions"][0]
        yield ["simulate", "plan.toml", "-o", name, "--seed", "3", "--quiet"], name
        yield ["convert", "data.h5", "-o", name, "--quiet"], name
    yield ["identify", "plan.toml", "data.h5", "-o", "out.json", "--quiet"], "out.json"
    yield ["certificate", "result.json", "--lab", "lab.toml", "-o", "out.html"], "out.html"
    yield ["certificate", "result.json", "--lab", "lab.toml", "-o", "out.xml"], "out.xml"
    yield ["report", "result.json", "-o", "out.html"], "out.html"
    for one in catalogue["exports"]:
        name = "out" + one["extension"]
        yield ["export", "result.json", "--to", one["name"], "-o", name], name


def problem_after(arguments, name, whole, folder, call, all_after):
    """What is wrong where this call fails; None: nothing. The second value: whether there is such a call."""
    target, seen = pathlib.Path(folder, name), pathlib.Path(folder, "seen")
    target.unlink(missing_ok=True)
    seen.unlink(missing_ok=True)
    environment = {"LD_PRELOAD": SHIM, "TUMBLE_FAULT": str(call), "TUMBLE_FAULT_SEEN": str(seen),
                   "ASAN_OPTIONS": "verify_asan_link_order=0:detect_leaks=0"}
    if all_after:
        environment["TUMBLE_FAULT_ON"] = "1"
    done = run(arguments, folder, environment)
    there = target.read_bytes() if target.exists() else None
    what = f"{' '.join(arguments)}: call {call} fails{', and all after it' if all_after else ''}: status {done.returncode}"
    if done.returncode < 0 or done.returncode == 4:
        return f"{what}: {done.stderr[-200:]}", seen.exists()
    if done.returncode == 0 and there != whole:
        return f"{what}, and the file is {'another one' if there is not None else 'not there'}", seen.exists()
    if there is not None and there != whole:
        return f"{what}: half a file under its name", seen.exists()
    return None, seen.exists()


def main():
    problems, calls = [], 0
    with tempfile.TemporaryDirectory() as folder:
        prepared(folder)
        for arguments, name in writers(folder):
            done = run(arguments, folder)
            if done.returncode != 0:
                continue  # not every result can be exported to everything
            whole = pathlib.Path(folder, name).read_bytes()
            for all_after in (False, True):
                for call in itertools.count(1):
                    problem, reached = problem_after(arguments, name, whole, folder, call, all_after)
                    if problem:
                        problems.append(problem)
                    if not reached:
                        break
                    calls += 1
                    assert call < MOST_CALLS, arguments
            print(f"{' '.join(arguments)}: {call - 1} calls", flush=True)
            assert call > 3, "the calls of the program are not reached: is it linked statically?"
    print(f"{calls} failing calls", *problems, sep="\n")
    sys.exit(1 if problems else 0)


main()
