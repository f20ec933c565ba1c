"""An operator's STOP never waits: whatever other users, a run that is stuck, or the memory do.

    serve_stop_test.py PROGRAM REPOSITORY
"""

import collections
import concurrent.futures
import contextlib
import fcntl
import json
import os
import pathlib
import re
import resource
import select
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import urllib.parse

from serve_stations_test import bench_files, read_if_there
from serve_test import PROGRAM, ROOT, Server, children, csv_file

PASSWORDS = {"Reader": "correct horse 1", "Operator": "correct horse 2", "Second": "correct horse 3"}
ROLES = {"Reader": "read", "Operator": "operate", "Second": "operate"}
QUICK = 5.0  # [s] a loaded machine answers within; what waits for others waits for 10 s and more
FAKE = """
import pathlib, signal, socket, sys
place = pathlib.Path(sys.argv[1])
signal.signal(signal.SIGTERM, lambda *_: (place / "told").write_text("SIGTERM"))
door = socket.socket(socket.AF_UNIX)
door.bind(str(place / "desk"))
door.listen(4)
print("ready", flush=True)
while True:
    signal.pause()
"""


class Cookies(dict):
    """Those of the users, who sign in when they are needed."""

    def __init__(self, sign_in):
        super().__init__()
        self.sign_in, self.lock = sign_in, threading.Lock()

    def __missing__(self, name):
        with self.lock:
            if name not in self:
                self[name] = self.sign_in(name)
            return self.get(name)


def raise_descriptors():
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 4096), hard))


class Shares(unittest.TestCase):
    """A user who may only read, with bad intentions; an operator with a run."""

    @classmethod
    def setUpClass(cls):
        raise_descriptors()
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="tumble-stop-"))
        cls.users, cls.archive = cls.scratch / "users.toml", cls.scratch / "lab.db"
        for name, password in PASSWORDS.items():
            subprocess.run([PROGRAM, "serve", "--users", cls.users, "--add-user", name, "--role", ROLES[name]], input=password + "\n", text=True,
                           check=True, capture_output=True)
        subprocess.run([PROGRAM, "archive", "init", "--archive", cls.archive, "--by", "test"], check=True, capture_output=True)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    def setUp(self):
        self.own_users = self.scratch / f"{self._testMethodName}.toml"
        shutil.copy(self.users, self.own_users)
        self.server = Server("--users", str(self.own_users), "--archive", str(self.archive))
        self.addCleanup(self.server.__exit__)
        self.cookies = Cookies(self.sign_in)

    def sign_in(self, name):
        body = json.dumps({"name": name, "password": PASSWORDS[name]})
        status, headers, content = self.server.ask("POST", "/api/session", body)
        self.assertEqual(status, 200, content)
        return headers["Set-Cookie"].split(";")[0]

    def ask(self, name, method, path, body=None):
        """(status, content, seconds)"""
        cookie = self.cookies[name]
        begin = time.monotonic()
        status, _, content = self.server.ask(method, path, json.dumps(body) if body is not None else None, {"Cookie": cookie})
        return status, json.loads(content), time.monotonic() - begin

    def quick(self, name, method, path, body=None, expect=200):
        status, content, seconds = self.ask(name, method, path, body)
        self.assertEqual(status, expect, content)
        self.assertLess(seconds, QUICK, f"{method} {path}")
        return content

    def stop(self, run, expect=200):
        return self.quick("Operator", "POST", "/api/station/order", {"run": run, "order": "stop"}, expect)

    def begun(self, speed="1"):
        """A run on a virtual rig."""
        bench_files(self.server.folder)
        body = {"mode": "virtual", "plan": "plan.toml", "station": "bench.toml", "units": {"unit": "7"}, "speed": speed}
        status, content, _ = self.ask("Operator", "POST", "/api/station/start", body)
        self.assertEqual(status, 201, content)
        run = content["run"]
        self.addCleanup(self.ended, run)
        return run

    def ended(self, run):
        for _ in range(600):
            status, content, _ = self.ask("Operator", "GET", "/api/station/run?run=" + urllib.parse.quote(run))
            if status == 200 and content["alive"] is False:
                return content["ending"]
            time.sleep(0.1)
        raise AssertionError(f"the run goes on: {content}")

    def process_of(self, run):
        folder = str(self.server.folder / run)
        return next(int(entry.name) for entry in pathlib.Path("/proc").iterdir()
                    if entry.name.isdigit() and f"-o\0{folder}\0".encode() in read_if_there(entry / "cmdline"))

    def held(self, count, path, name="Reader", method="GET", body=b"", length=None):
        """Connections that have asked, and read nothing."""
        self.cookies["Operator"]  # signs in before the others take what they can
        head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{self.server.port}\r\nCookie: {self.cookies[name]}\r\n"
        head += f"Content-Length: {length}\r\n" if length else ""
        clients = []
        for _ in range(count):
            client = socket.create_connection(("127.0.0.1", self.server.port), timeout=20)
            self.addCleanup(client.close)
            with contextlib.suppress(OSError):  # the server may hang up meanwhile
                client.sendall(head.encode() + b"\r\n" + body)
            clients.append(client)
        return clients

    def test_long_requests_of_another_user(self):
        run = self.begun()
        lock = sqlite3.connect(self.archive, isolation_level=None)
        self.addCleanup(lock.close)
        lock.execute("BEGIN EXCLUSIVE")  # each question to the archive waits for seconds now
        self.held(150, "/api/archive/units")
        for _ in range(3):
            self.quick("Operator", "GET", "/api/jobs")
        self.assertEqual(self.stop(run), {"taken": True})
        self.assertEqual(self.ended(run), "stopped")

    def test_streams_and_connections_of_another_user(self):
        run = self.begun()
        statuses = collections.Counter()
        for client in self.held(950, "/api/events"):
            client.settimeout(20)
            with contextlib.suppress(OSError):
                statuses[client.recv(100)[9:12]] += 1
        self.assertLessEqual(set(statuses), {b"200", b"429", b"503", b""})  # 503: more of them wait than a busy machine has answered
        self.assertGreater(statuses[b"200"], 0)
        self.assertLess(statuses[b"200"], 400)  # a quarter of 900 connections, and others after streams that were closed to make room
        self.assertGreater(statuses[b"429"] + statuses[b"503"], 50)
        idle = [socket.create_connection(("127.0.0.1", self.server.port), timeout=20) for _ in range(400)]  # nobody knows whose
        for client in idle:
            self.addCleanup(client.close)
        self.quick("Operator", "GET", "/api/jobs")
        self.assertEqual(self.stop(run), {"taken": True})
        self.assertEqual(self.ended(run), "stopped")

    def test_a_run_that_is_suspended(self):
        run = self.begun()
        process = self.process_of(run)
        os.kill(process, signal.SIGSTOP)
        address = "/api/station/run?run=" + urllib.parse.quote(run)
        with concurrent.futures.ThreadPoolExecutor(12) as pool:
            looks = [pool.submit(self.ask, "Reader", "GET", address) for _ in range(8)]
            orders = [pool.submit(self.ask, "Second", "POST", "/api/station/order", {"run": run, "order": "pause"}) for _ in range(4)]
            self.quick("Operator", "GET", "/api/jobs")
            self.assertEqual(self.stop(run), {"taken": True})  # and its process goes on
            for look in looks + orders:
                self.assertIn(look.result()[0], (200, 400, 404, 422))
        self.assertEqual(self.ended(run), "stopped")

    def test_a_run_that_does_not_answer(self):
        run = self.server.folder / "runs/fake"
        run.mkdir(parents=True)
        with subprocess.Popen([sys.executable, "-c", FAKE, str(run)], stdout=subprocess.PIPE, text=True) as process:
            self.addCleanup(process.kill)
            self.assertEqual(process.stdout.readline(), "ready\n")
            # More looks than the desk takes connections: the kernel keeps the rest waiting.
            with concurrent.futures.ThreadPoolExecutor(24) as pool:
                looks = [pool.submit(self.ask, "Reader", "GET", "/api/station/run?run=runs/fake") for _ in range(12)]
                looks += [pool.submit(self.ask, "Reader", "GET", "/api/station") for _ in range(4)]
                self.quick("Operator", "GET", "/api/jobs")
                content = self.stop("runs/fake", expect=422)
                self.quick("Operator", "GET", "/api/jobs")
                for look in looks:
                    self.assertIn(look.result()[0], (200, 422))
            self.assertEqual(content["problems"], [f"the run 'runs/fake' does not answer; its process {process.pid} has got the signal to stop: "
                                                   "watch the rig, and press its emergency stop if it moves on"])
            self.assertEqual((run / "told").read_text(), "SIGTERM")
            process.kill()

    def fake_run(self, name):
        """A run that takes connections, and answers nothing."""
        run = self.server.folder / name
        run.mkdir(parents=True)
        process = subprocess.Popen([sys.executable, "-c", FAKE, str(run)], stdout=subprocess.PIPE, text=True)
        self.addCleanup(process.stdout.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        self.assertEqual(process.stdout.readline(), "ready\n")

    def test_stops_wait_for_their_own_run_alone(self):
        run = self.begun()
        self.fake_run("runs/fake")
        self.fake_run("runs/fake-2")
        cookie = {"Cookie": self.cookies["Operator"]}

        def press(number):
            body = json.dumps({"run": ("runs/fake", "runs/fake-2")[number % 2], "order": "stop"})
            return self.server.ask("POST", "/api/station/order", body, cookie)[0]
        with concurrent.futures.ThreadPoolExecutor(40) as pool:
            begin = time.monotonic()
            presses = [pool.submit(press, number) for number in range(40)]  # somebody in fear
            self.assertEqual(self.stop(run), {"taken": True})
            self.assertEqual({one.result() for one in presses}, {422})
            # One by one, 20 of a run would take 3 s each: who waits gets the answer of the next time.
            self.assertLess(time.monotonic() - begin, 20.0)
        self.assertEqual(self.ended(run), "stopped")

    def test_a_file_of_users_whose_disk_does_not_answer(self):
        run = self.begun()
        stream = self.stream("Reader")
        signal.signal(signal.SIGIO, signal.SIG_IGN)  # somebody wants the file
        self.own_users.write_text(self.own_users.read_text() + "# changed\n")
        with open(self.own_users) as file:
            try:
                fcntl.fcntl(file, fcntl.F_SETLEASE, fcntl.F_WRLCK)  # who opens it waits until we let it go, or 45 s
            except OSError as error:
                self.skipTest(f"this disk has no leases: {error}")
            begin = time.monotonic()
            self.quick("Operator", "GET", "/api/jobs")
            self.assertEqual(self.stop(run), {"taken": True})
            self.quick("Reader", "GET", "/api/station")
            if time.monotonic() - begin < 15:
                self.assertNotEqual(fcntl.fcntl(file, fcntl.F_GETLEASE), fcntl.F_UNLCK)
            stream.close()
        self.assertEqual(self.ended(run), "stopped")

    def test_who_guesses_passwords(self):
        ended = threading.Event()

        def guess(number):
            attempt = 0
            while not ended.is_set():
                attempt += 1
                body = json.dumps({"name": f"guess {number} {attempt}", "password": "a wrong horse"})
                self.assertEqual(self.server.ask("POST", "/api/session", body)[0], 403)
        with concurrent.futures.ThreadPoolExecutor(6) as pool:
            guesses = [pool.submit(guess, number) for number in range(6)]
            for _ in range(2):
                self.sign_in("Operator")
            ended.set()
            for one in guesses:
                one.result()

    def test_bodies_that_do_not_end(self):
        def memory():
            text = pathlib.Path(f"/proc/{self.server.process.pid}/status").read_text()
            return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) * 1024
        before = memory()
        part = b'{"text": "' + b"x" * 3_900_000
        clients = self.held(60, "/api/plan/predict", method="POST", body=part, length=3_990_000)
        refused = select.select(clients, [], [], 20)[0]  # the others wait for the rest of their bodies
        self.assertTrue(any(client.recv(12)[9:] == b"503" for client in refused))
        # One party has 16 MB; a text grows by doubling, and what is freed may stay with the process.
        self.assertLess(memory() - before, 120e6)
        plan = (ROOT / "plans/static_bias.toml").read_text()
        for text in (plan, plan + "#" * 900_000):
            self.quick("Operator", "POST", "/api/plan/look", {"text": text, "file": "p.toml"})

    def stream(self, name, path="/api/events"):
        client = self.held(1, path, name)[0]
        client.settimeout(20)
        self.assertIn(b"200 OK", client.recv(4096))
        return client

    def assert_ends(self, client):
        with contextlib.suppress(ConnectionResetError):
            while client.recv(4096):
                pass

    def test_streams_end_with_the_session(self):
        for path in ("/api/events", "/api/station/run/events?run="):
            if path.endswith("="):
                path += urllib.parse.quote(self.begun("50"))
            reader, operator = self.stream("Reader", path), self.stream("Operator", path)
            other = self.stream("Second", path)
            self.assertEqual(self.ask("Reader", "POST", "/api/session/end", {})[0], 200)
            self.assert_ends(reader)
            text = self.own_users.read_text()
            self.own_users.write_text(re.sub(r'\[\[user\]\]\nname = "Second"\n[^[]*roles = [^\n]*', '[[user]]\nname = "Second"\nroles = []', text))
            self.assert_ends(other)
            operator.setblocking(False)
            with contextlib.suppress(BlockingIOError):  # it goes on
                while True:
                    self.assertNotEqual(operator.recv(4096), b"")
            operator.close()
            self.own_users.write_text(text)
            self.cookies["Reader"] = self.sign_in("Reader")
        for entry in (self.server.folder / "runs").iterdir():
            if entry.is_dir():
                self.stop(f"runs/{entry.name}")

    def test_a_user_has_a_share_of_the_queue(self):
        csv_file(self.server.folder / "a.csv", 100)
        suspended = []

        def suspend():
            for child in children(self.server.process.pid):
                if child not in suspended:
                    with contextlib.suppress(ProcessLookupError):  # it was quick
                        os.kill(child, signal.SIGSTOP)
                        suspended.append(child)

        def end():
            for child in suspended:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)
        self.addCleanup(end)
        statuses = []
        for _ in range(140):
            suspend()
            statuses.append(self.ask("Operator", "POST", "/api/jobs/convert", {"file": "a.csv", "to": "b.h5"})[:2])
            if statuses[-1][0] != 202:
                break
        self.assertEqual(statuses[-1][0], 400)
        self.assertRegex(statuses[-1][1]["problems"][0], "^100 jobs of yours wait already")
        self.assertEqual(self.ask("Second", "POST", "/api/jobs/convert", {"file": "a.csv", "to": "b.h5"})[0], 202)


class LittleMemory(unittest.TestCase):
    def test_the_server_goes_on_without_memory_for_a_body(self):
        with Server() as server:
            server.ask("GET", "/api/jobs")
            size = int(re.search(r"VmSize:\s+(\d+)", pathlib.Path(f"/proc/{server.process.pid}/status").read_text())[1]) * 1024
            most = resource.prlimit(server.process.pid, resource.RLIMIT_AS)[1]
            resource.prlimit(server.process.pid, resource.RLIMIT_AS, (size + (1 << 20), most))
            body = b'{"text": "' + b"x" * 3_900_000 + b'"}'
            statuses = set()
            for _ in range(20):
                with contextlib.suppress(OSError):  # it may hang up while the rest is sent
                    statuses.add(server.ask("POST", "/api/plan/predict", body)[0])
                self.assertIsNone(server.process.poll())
            self.assertEqual(statuses, {503})
            resource.prlimit(server.process.pid, resource.RLIMIT_AS, (most, most))
            self.assertEqual(server.ask("GET", "/api/jobs")[0], 200)


class Link(unittest.TestCase):
    def test_who_has_signed_out_of_a_link_is_out(self):
        with Server() as server:
            cookies = [server.ask("POST", "/api/session", json.dumps({"token": server.token}), token=False)[1]["Set-Cookie"].split(";")[0]
                       for _ in range(2)]
            self.assertNotEqual(*cookies)
            self.assertEqual(server.ask("POST", "/api/session/end", "{}", {"Cookie": cookies[0]}, token=False)[0], 200)
            self.assertEqual([server.ask("GET", "/api/jobs", None, {"Cookie": cookie}, token=False)[0] for cookie in cookies], [401, 200])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
