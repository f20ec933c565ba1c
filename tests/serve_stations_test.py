"""Stations and runs through the server, as a page asks for them.

    serve_stations_test.py PROGRAM REPOSITORY
"""

import contextlib
import json
import os
import pathlib
import random
import resource
import shutil
import signal
import socket
import subprocess
import sys
import time
import unittest

from serve_test import PROGRAM, ROOT, Server, alive, events


def free_port():
    """Below the ports that a system gives to connections: none of those takes it before the program listens."""
    while True:
        with socket.socket() as door, contextlib.suppress(OSError):
            door.bind(("127.0.0.1", random.randrange(20000, 32000)))
            return door.getsockname()[1]


def bench_files(folder):
    """The station of the rate table at free ports, and its plan."""
    shutil.copytree(ROOT / "stations/frames", folder / "frames")
    station = (ROOT / "stations/gyro_scale_factor.toml").read_text()
    for port in ("21151", "21152", "21153"):
        station = station.replace(port, str(free_port()))
    (folder / "bench.toml").write_text(station)
    shutil.copy(ROOT / "plans/gyro_scale_factor.toml", folder / "plan.toml")


def read_if_there(path):
    with contextlib.suppress(OSError):
        return path.read_bytes()
    return b""


class Stations(unittest.TestCase):
    RUN = {"mode": "virtual", "plan": "plan.toml", "station": "bench.toml", "units": {"unit": "7"}, "who": "a test", "speed": "20"}

    def test_what_is_wrong_is_refused_and_nothing_is_begun(self):
        with Server() as server:
            bench_files(server.folder)
            for change in ({"mode": "fly"}, {"plan": "../plan.toml"}, {"plan": 7}, {"who": "a\nb"}, {"who": "x" * 2000}):
                status, _, content = server.ask("POST", "/api/station/start", json.dumps({**self.RUN, **change}))
                self.assertIn(status, (400, 422), f"{change} {content}")
            for body in (b"", b"[]", b"{", b"7"):
                self.assertEqual(server.ask("POST", "/api/station/start", body)[0], 400)
            refused = server.json("POST", "/api/station/start", {**self.RUN, "units": {"other": "7"}, "who": ""}, expect=(422,))["problems"]
            self.assertTrue(any("the operator is missing" in problem for problem in refused), refused)
            self.assertTrue(any("the station has no slot 'other'" in problem for problem in refused), refused)
            self.assertTrue(any("the unit has no serial number" in problem for problem in refused), refused)
            self.assertFalse((server.folder / "runs").exists())
            for name in ("", "..", "../x", "/etc", "runs/none", "%00", "plan.toml"):
                self.assertIn(server.ask("GET", f"/api/station/run?run={name}")[0], (400, 404))
                self.assertIn(server.ask("GET", f"/api/station/run/events?run={name}")[0], (400, 404))
            self.assertEqual(server.ask("POST", "/api/station/order", json.dumps({"run": "frames", "order": "stop"}))[0], 404)
            self.assertEqual(server.ask("POST", "/api/station/start", json.dumps(self.RUN), token=False)[0], 401)
            self.assertEqual(server.ask("POST", "/api/station/order", b"{}", headers={"Origin": "http://evil.example"})[0], 403)
            # A serial number is a number of the unit, whatever it looks like: it is never an option of the program.
            hostile = server.json("POST", "/api/station/dry-run", {**self.RUN, "units": {"unit": "--speed=1000; rm -rf /"}})
            self.assertEqual(hostile["problems"], [])

    def test_a_disk_without_room_is_said(self):
        with Server() as server:
            bench_files(server.folder)
            most = resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE)[1]
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (0, most))  # no file takes a byte, as on a full disk
            for mode in ("virtual", "rehearse"):
                problems = server.json("POST", "/api/station/start", {**self.RUN, "mode": mode}, expect=(422,))["problems"]
                self.assertRegex(problems[0], r"^the run was not begun: cannot write 'runs/plan-[-0-9]+\.log': File too large$")
            chinese = server.json("POST", "/api/station/start?language=zh", self.RUN, expect=(422,))["problems"]
            self.assertRegex(chinese[0], "^试验没有开始：无法写入“runs/plan-[-0-9]+\\.log”：文件过大$")
            self.assertEqual(list((server.folder / "runs").iterdir()), [])
            resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (1000, most))  # room for messages, none for the run
            problems = server.json("POST", "/api/station/start", self.RUN, expect=(422,))["problems"]
            self.assertRegex(problems[0], r"^the run was not begun: cannot write 'runs/plan-[-0-9]+/plan\.toml': File too large$")
            self.assertEqual([path.suffix for path in (server.folder / "runs").iterdir()], [".log"])

    def test_a_run_survives_its_server_and_ctrl_c_at_the_terminal_of_the_server(self):
        with Server() as server:
            bench_files(server.folder)
            run = server.json("POST", "/api/station/start", self.RUN)["run"]
            folder = str(server.folder / run)
            state = server.json("GET", f"/api/station/run?run={run}")
            self.assertTrue(state["alive"])
            self.assertEqual(state["facts"]["rig"], "virtual")
            self.assertEqual(state["facts"]["units"], {"unit": "7"})
            process = next(int(entry.name) for entry in pathlib.Path("/proc").iterdir() if entry.name.isdigit()
                           and f"-o\0{folder}\0".encode() in read_if_there(entry / "cmdline"))
            self.assertNotIn(server.process.pid, (os.getsid(process), os.getpgid(process)), "Ctrl+C goes to a group")
            self.assertNotEqual(os.getsid(process), os.getsid(server.process.pid), "a terminal that is closed ends its session")
            server.stop(signal.SIGINT)
            answer = [PROGRAM, "answer", folder]
            for _ in range(200):
                asked = subprocess.run(answer, capture_output=True, text=True, timeout=60).stdout
                if "answer one of" in asked:
                    break
                time.sleep(0.1)
            self.assertIn("answer one of: done, stop", asked)
            self.assertEqual(subprocess.run([*answer, "done", "--operator", "a test"], timeout=60).returncode, 0)
            with Server(folder=server.folder) as again:
                runs = again.json("GET", "/api/station")["runs"]
                self.assertEqual([(one["run"], one["alive"]) for one in runs], [(run, True)])
                ids = [event["id"] for event in again.json("GET", f"/api/station/run?run={run}")["events"]]
                self.assertEqual(ids, sorted(set(ids)))
                again.json("POST", "/api/station/order", {"run": run, "order": "stop"})
                for _ in range(300):
                    state = again.json("GET", f"/api/station/run?run={run}", expect=(200, 422))
                    if state.get("alive") is False:
                        break
                    time.sleep(0.1)
                self.assertEqual(state["ending"], "stopped")
                stored = [event["id"] for event in state["events"]]
                self.assertEqual([one for one in stored if one in ids], ids, "what was seen is what is stored")
                self.assertEqual(again.ask("POST", "/api/station/order", json.dumps({"run": run, "order": "stop"}))[0], 404)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
