"""`tumble serve` as its users and its enemies meet it: a real server, real sockets, real jobs.

    serve_test.py PROGRAM REPOSITORY
"""

import contextlib
import http.client
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import ssl
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

PROGRAM, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])


class Server:
    """A server over a new folder; ended with the block."""

    def __init__(self, *arguments, folder=None, environment=None):
        self.own = folder is None
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="tumble-serve-"))
        self.folder = folder or self.scratch / "data"
        self.folder.mkdir(exist_ok=True)
        self.cache = self.scratch / "cache"
        self.state = self.folder.parent / "state"  # a server that is started again over a folder knows its jobs
        self.process = subprocess.Popen([PROGRAM, "serve", str(self.folder), "--port", "0", *arguments], text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        env={**os.environ, "XDG_CACHE_HOME": str(self.cache), "XDG_STATE_HOME": str(self.state),
                                             **(environment or {})})
        lines = [self.process.stdout.readline() for _ in range(2)]
        match = re.search(r"(https?)://(.+):(\d+)/(?:#token=([0-9a-f]+))?", lines[1])
        if not match:
            raise RuntimeError(f"no link: {lines} {self.process.stderr.read()}")
        self.port, self.token = int(match[3]), match[4]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
        shutil.rmtree(self.scratch)

    def stop(self, how=signal.SIGTERM):
        if self.process.poll() is None:
            self.process.send_signal(how)
            self.process.wait(20)
        self.process.stdout.close()
        self.process.stderr.close()

    def ask(self, method, path, body=None, headers=None, token=True):
        """(status, headers, bytes)"""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        own = {"Authorization": f"Bearer {self.token}"} if token and self.token else {}
        connection.request(method, path, body, {**own, **(headers or {})})
        response = connection.getresponse()
        answer = response.status, dict(response.getheaders()), response.read()
        connection.close()
        return answer

    def json(self, method, path, body=None, expect=(200, 201, 202)):
        status, _, content = self.ask(method, path, json.dumps(body) if body is not None else None)
        if status not in expect:
            raise AssertionError(f"{method} {path}: {status} {content[:300]}")
        return json.loads(content)

    def raw(self, text, wait=5.0):
        """What a client gets that sends these bytes and listens."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=wait) as client:
            client.sendall(text)
            received = b""
            with contextlib.suppress(TimeoutError, ConnectionResetError):
                while piece := client.recv(65536):
                    received += piece
            return received

    def job(self, identity, states=("done", "failed", "cancelled"), seconds=60):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            job = next(job for job in self.json("GET", "/api/jobs")["jobs"] if job["id"] == identity)
            if job["state"] in states:
                return job
            time.sleep(0.05)
        raise AssertionError(f"the job is still {job}")

    def prepared(self, name, **query):
        query = urllib.parse.urlencode({"file": name, **query})
        for _ in range(600):
            status, _, content = self.ask("GET", f"/api/recording?{query}")
            answer = json.loads(content)
            if status not in (200, 202) or (status == 200 and answer["findings"] is not None):
                return status, answer
            time.sleep(0.05)
        raise AssertionError("the recording is never ready")


def csv_file(path, samples=4000, gap=None):
    """Two channels at 100 Hz; a gap after sample `gap`."""
    with open(path, "w") as file:
        file.write("time[s],gyro.x[deg/h],acc.z[m/s^2]\n")
        for i in range(samples):
            late = 0.5 if gap is not None and i > gap else 0.0
            file.write(f"{i * 0.01 + late:.4f},{(i * 7919 % 1009) / 1009 - 0.5:.6f},{9.8 + (i * 104729 % 997) * 1e-6:.8f}\n")


class Doors(unittest.TestCase):
    """Who gets in."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        csv_file(cls.server.folder / "a.csv")

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    def test_without_token_only_the_page_is_served(self):
        for path in ("/", "/app.js", "/app.css", "/openapi.json", "/api/texts?language=zh"):
            status, headers, content = self.server.ask("GET", path, token=False)
            self.assertEqual(status, 200, path)
            self.assertGreater(len(content), 200)
            self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        for path in ("/api/recordings", "/api/jobs", "/api/events", "/api/recording?file=a.csv"):
            self.assertEqual(self.server.ask("GET", path, token=False)[0], 401, path)
            wrong = {"Authorization": "Bearer " + "0" * 64}
            self.assertEqual(self.server.ask("GET", path, headers=wrong, token=False)[0], 401, path)

    def test_the_token_becomes_a_cookie(self):
        body = json.dumps({"token": self.server.token})
        status, headers, _ = self.server.ask("POST", "/api/session", body, token=False)
        self.assertEqual(status, 200)
        cookie = headers["Set-Cookie"]
        self.assertIn("HttpOnly", cookie)
        self.assertIn("SameSite=Strict", cookie)
        self.assertNotIn(self.server.token, cookie)
        name = cookie.split(";")[0]
        self.assertEqual(self.server.ask("GET", "/api/jobs", headers={"Cookie": f"other=1; {name}"}, token=False)[0], 200)
        self.assertEqual(self.server.ask("GET", "/api/jobs", headers={"Cookie": name + "0"}, token=False)[0], 401)
        for bad in ('{"token": "no"}', '{"token": 7}', "[", '"' + self.server.token + '"'):
            self.assertEqual(self.server.ask("POST", "/api/session", bad, token=False)[0], 401, bad)

    def test_unknown_addresses_are_404(self):
        for path in ("/index.html", "/api", "/api/", "/api/nothing", "/..", "/app.js/", "//", "/api/recordings/"):
            self.assertEqual(self.server.ask("GET", path)[0], 404, path)
        status, headers, _ = self.server.ask("DELETE", "/api/jobs")
        self.assertEqual((status, headers["Allow"]), (405, "GET"))

    def test_names_of_other_computers_are_refused(self):
        for host in ("evil.example", f"evil.example:{self.server.port}", "127.0.0.1", "127.0.0.1:1", f"8.8.8.8:{self.server.port}",
                     f"localhost.evil.example:{self.server.port}", f"127.evil.example:{self.server.port}"):
            self.assertEqual(self.server.ask("GET", "/api/jobs", headers={"Host": host})[0], 421, host)
        for host in (f"localhost:{self.server.port}", f"127.0.0.1:{self.server.port}", f"[::1]:{self.server.port}"):
            self.assertEqual(self.server.ask("GET", "/api/jobs", headers={"Host": host})[0], 200, host)

    def test_pages_of_other_sites_are_refused(self):
        here = f"http://127.0.0.1:{self.server.port}"
        for origin in ("http://evil.example", "null", f"https://127.0.0.1:{self.server.port}", "http://127.0.0.1:1"):
            self.assertEqual(self.server.ask("POST", "/api/jobs/cancel?id=1", headers={"Origin": origin})[0], 403, origin)
        self.assertEqual(self.server.ask("POST", "/api/jobs/cancel?id=1", headers={"Origin": here})[0], 404)
        self.assertEqual(self.server.ask("GET", "/api/jobs", headers={"Sec-Fetch-Site": "cross-site"})[0], 403)
        link = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}
        self.assertEqual(self.server.ask("GET", "/", headers=link)[0], 200)
        self.assertEqual(self.server.ask("GET", "/api/jobs", headers=link)[0], 403)

    def test_paths_lead_nowhere_else(self):
        outside = self.server.scratch / "secret.csv"
        csv_file(outside)
        (self.server.folder / "link.csv").symlink_to(outside)
        (self.server.folder / "up").symlink_to(self.server.scratch)
        for name in ("../secret.csv", "%2e%2e/secret.csv", "..%2fsecret.csv", "/etc/passwd", str(outside), "link.csv", "up/secret.csv",
                     "a.csv/../../secret.csv", "./a.csv", ".hidden", "", "a.csv%0a", "a%ff.csv", "sub//a.csv"):
            status, _, content = self.server.ask("GET", f"/api/recording?file={name}")
            self.assertIn(status, (400, 404), f"{name}: {content}")
        self.assertEqual(self.server.ask("GET", "/api/recording?file=a.csv%00.h5")[0], 400)
        listed = [entry["name"] for entry in self.server.json("GET", "/api/recordings")["recordings"]]
        self.assertEqual(listed, ["a.csv"])

    def test_requests_that_are_none(self):
        port = self.server.port
        host = f"Host: 127.0.0.1:{port}\r\n"
        for request, status in (
                (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"400"),
                (f"GET / HTTP/1.1\r\n{host}X: {'a' * 20000}\r\n\r\n".encode(), b"431"),
                (f"GET /{'a' * 20000} HTTP/1.1\r\n{host}\r\n".encode(), b"431"),
                (b"GET / HTTP/1.1\r\n\r\n", b"400"),
                (f"GET / HTTP/1.1\r\n{host}{host}\r\n".encode(), b"400"),
                (f"GET http://evil/ HTTP/1.1\r\n{host}\r\n".encode(), b"400"),
                (f"GET /%zz HTTP/1.1\r\n{host}\r\n".encode(), b"400"),
                (f"POST /api/session HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\nzz\r\n".encode(), b"400"),
                (f"POST /api/session HTTP/1.1\r\n{host}Content-Length: 999999999999\r\n\r\n".encode(), b"413"),
                (f"POST /api/session HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\n2000\r\n{'a' * 8192}\r\n".encode(), b"413"),
                (f"POST /api/session HTTP/1.1\r\n{host}Content-Length: -5\r\n\r\n".encode(), b"400"),
                (f"POST /api/session HTTP/1.1\r\n{host}Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n".encode(), b"400"),
        ):
            answer = self.server.raw(request)
            self.assertTrue(answer.startswith(b"HTTP/1.1 " + status), f"{request[:80]} -> {answer[:120]}")
        self.assertEqual(self.server.ask("GET", "/api/jobs")[0], 200)

    def test_many_idle_connections_keep_nobody_out(self):
        clients = []
        try:
            for i in range(1100):
                client = socket.create_connection(("127.0.0.1", self.server.port), timeout=10)
                if i % 3 == 0:
                    client.sendall(b"GET / HTTP/1.1\r\nHo")
                clients.append(client)
            begin = time.monotonic()
            self.assertEqual(self.server.ask("GET", "/api/jobs")[0], 200)
            self.assertLess(time.monotonic() - begin, 5.0)
        finally:
            for client in clients:
                client.close()

    def test_a_slow_head_is_cut_off(self):
        with Server("--no-token") as server, socket.create_connection(("127.0.0.1", server.port), timeout=40) as client:
            client.sendall(b"GET / HTTP/1.1\r\n")
            begin = time.monotonic()
            with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                while time.monotonic() - begin < 35:
                    client.sendall(b"X: y\r\n")
                    client.settimeout(1.0)
                    with contextlib.suppress(TimeoutError):
                        if client.recv(100) == b"":
                            break
            self.assertLess(time.monotonic() - begin, 30)


class Uploads(unittest.TestCase):
    def test_files_and_names(self):
        with Server("--upload-limit", "100 kB") as server:
            csv_file(server.scratch / "a.csv", 500)
            content = (server.scratch / "a.csv").read_bytes()
            self.assertEqual(server.json("POST", "/api/uploads?name=day%201.csv", None, (400,))["problems"], ["'day 1.csv' is empty"])
            status, _, answer = server.ask("POST", "/api/uploads?name=day%201.csv", content)
            self.assertEqual((status, json.loads(answer)["name"]), (201, "uploads/day 1.csv"))
            status, _, answer = server.ask("POST", "/api/uploads?name=day%201.csv", content)
            self.assertEqual((status, json.loads(answer)["name"]), (201, "uploads/day 1-2.csv"))
            self.assertEqual((server.folder / "uploads/day 1.csv").read_bytes(), content)
            for name in ("../x.csv", "a/b.csv", "%2e%2e%2fx", ".x", "-x", "a%0ab.csv", "a%0db", "", "a" * 201, "a%5cb", "%ff%fe"):
                self.assertEqual(server.ask("POST", f"/api/uploads?name={name}", content)[0], 400, name)
            self.assertEqual(server.ask("POST", "/api/uploads?name=large.csv", b"x" * 100_001)[0], 413)
            head = (f"POST /api/uploads?name=cut.csv HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nAuthorization: Bearer {server.token}\r\n"
                    "Content-Length: 5000\r\n\r\nhalf")
            with socket.create_connection(("127.0.0.1", server.port)) as client:
                client.sendall(head.encode())
                time.sleep(0.2)
            time.sleep(0.3)
            self.assertEqual(sorted(path.name for path in (server.folder / "uploads").iterdir()), ["day 1-2.csv", "day 1.csv"])

    def test_a_folder_of_uploads_that_leads_outside(self):
        with Server() as server:
            (server.scratch / "elsewhere").mkdir()
            (server.folder / "uploads").symlink_to(server.scratch / "elsewhere")
            self.assertEqual(server.ask("POST", "/api/uploads?name=a.csv", b"x")[0], 400)
            self.assertEqual(list((server.scratch / "elsewhere").iterdir()), [])


class Recordings(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        csv_file(cls.server.folder / "a.csv", gap=2000)
        (cls.server.folder / "norate.csv").write_text("x[deg/h]\n" + "".join(f"{i % 7}\n" for i in range(500)))
        (cls.server.folder / "bad.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + b"\0" * 200)

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    def test_what_is_in_it(self):
        status, answer = self.server.prepared("a.csv")
        self.assertEqual(status, 200)
        self.assertEqual([channel["name"] for channel in answer["channels"]], ["gyro.x", "acc.z"])
        self.assertIn("rad/s", answer["channels"][0]["units"])
        self.assertIn("gap", [finding["code"] for finding in answer["findings"]])
        self.assertRegex(answer["sha256"], "^[0-9a-f]{64}$")

    def test_findings_are_said_in_the_language_of_the_page(self):
        english, chinese = self.server.prepared("a.csv", language="en")[1], self.server.prepared("a.csv", language="zh")[1]
        self.assertEqual(english, self.server.prepared("a.csv")[1])
        for one, other in zip(english["findings"], chinese["findings"], strict=True):
            self.assertRegex(other.pop("message"), "[\u4e00-\u9fff]")
            self.assertNotRegex(one.pop("message"), "[\u4e00-\u9fff]")
            self.assertEqual(one, other)
        self.assertEqual(self.server.ask("GET", "/api/recording?file=a.csv&language=fr")[0], 404)

    def test_view_statistics_values_and_csv_agree(self):
        self.server.prepared("a.csv")
        span = "file=a.csv&from=5&to=10&channel=gyro.x&unit=rad/s"
        rows = self.server.ask("GET", f"/api/recording/csv?{span}")[2].decode().splitlines()
        self.assertEqual(rows[0], "time[s],gyro.x[rad/s]")
        values = [float(row.split(",")[1]) for row in rows[1:]]
        times = [float(row.split(",")[0]) for row in rows[1:]]
        self.assertEqual((len(values), times[0], times[-1]), (501, 5.0, 10.0))
        of = self.server.json("GET", f"/api/recording/statistics?{span}")["rows"][0]
        self.assertEqual((of["samples"], of["missing"]), (501, 0))
        mean = sum(values) / len(values)
        self.assertAlmostEqual(of["mean"], mean, delta=1e-12 * max(map(abs, values)))
        self.assertEqual((of["minimum"], of["maximum"]), (min(values), max(values)))
        view = self.server.ask("GET", f"/api/recording/view?{span}&pixels=100")[2]
        head = struct.unpack_from("<8d", view)
        self.assertEqual((head[0], head[1]), (1.0, 0.0))
        count, first, block, offset = int(head[2]), int(head[3]), int(head[4]), head[5]
        place = 64 + 8 * count  # stamped: the times come first
        low = struct.unpack_from(f"<{count}f", view, place)
        high = struct.unpack_from(f"<{count}f", view, place + (4 * count + 7) // 8 * 8)
        self.assertLessEqual(offset + min(low), min(values))
        self.assertGreaterEqual(offset + max(high), max(values))
        self.assertLessEqual(count * block - len(values), 2 * block + 2)
        two = self.server.json("GET", "/api/recording/values?file=a.csv&channel=gyro.x&at=5&at=10")["rows"][0]
        self.assertEqual(two["time_difference"], 5.0)
        self.assertAlmostEqual(two["difference"], two["values"][1]["value"] - two["values"][0]["value"], places=12)

    def test_what_the_file_does_not_say_can_be_said(self):
        status, answer = self.server.prepared("norate.csv")
        self.assertEqual(status, 422)
        self.assertIn("rate", answer["problems"][0])
        status, answer = self.server.prepared("norate.csv", set="rate=50")
        self.assertEqual((status, answer["channels"][0]["rate"]), (200, 50.0))
        for text in ("calibration=/etc/passwd", "frames=/etc/passwd", "nonsense"):
            self.assertEqual(self.server.ask("GET", "/api/recording?file=norate.csv&set=" + urllib.parse.quote(text))[0], 400, text)

    def test_a_damaged_file_is_said_and_hurts_nobody(self):
        status, answer = self.server.prepared("bad.h5")
        self.assertEqual(status, 422)
        self.assertTrue(answer["problems"])
        self.assertEqual(self.server.ask("GET", "/api/jobs")[0], 200)

    def test_parameters_that_are_wrong(self):
        self.server.prepared("a.csv")
        for query in ("from=a&to=1&pixels=9", "from=1&to=0&pixels=9", "from=0&to=nan&pixels=9", "from=0&to=1&pixels=0",
                      "from=0&to=1&pixels=1e9", "from=0&to=1", "from=0&to=1&pixels=9&channel=none",
                      "from=0&to=1&pixels=9&channel=gyro.x&unit=m", "from=0&to=1&pixels=9&channel=gyro.x&unit=what",
                      "from=0&to=1&pixels=9&unit=deg/h"):
            self.assertEqual(self.server.ask("GET", f"/api/recording/view?file=a.csv&{query}")[0], 400, query)


class Jobs(unittest.TestCase):
    def test_identify_with_a_plan_and_noise_of_a_span(self):
        with Server() as server:
            shutil.copy(ROOT / "examples/data/mpu6050_static.csv", server.folder / "still.csv")
            answer = server.json("POST", "/api/jobs/identify", {"recordings": ["still.csv"], "method": "allan_noise", "language": "zh"})
            job = server.job(answer["job"])
            self.assertEqual((job["state"], job["problems"], job["files"]), ("done", [], ["report.html", "result.json"]))
            status, headers, page = server.ask("GET", f"/api/jobs/file?id={job['id']}&name=report.html")
            self.assertEqual(status, 200)
            self.assertIn("sandbox", headers["Content-Security-Policy"])
            self.assertIn('lang="zh', page.decode())
            channel = server.prepared("still.csv")[1]["channels"][0]
            span = {"file": "still.csv", "from": channel["first"], "to": channel["first"] + 20, "channels": [channel["name"]]}
            job = server.job(server.json("POST", "/api/jobs/noise", span)["job"])
            self.assertEqual((job["state"], job["problems"]), ("done", []))
            self.assertNotIn("span.h5", job["files"])
            self.assertTrue([name for name in job["files"] if name.endswith(".svg")], job["files"])
            for name in ("job.json", "../../still.csv", "nothing"):
                self.assertEqual(server.ask("GET", f"/api/jobs/file?id={job['id']}&name={name}")[0], 404, name)
            job = server.job(server.json("POST", "/api/jobs/convert", {"file": "still.csv", "to": "still.h5"})["job"])
            self.assertEqual((job["state"], job["files"]), ("done", ["still.h5"]))

    def test_requests_that_are_wrong(self):
        with Server() as server:
            csv_file(server.folder / "a.csv", 300)
            for path, body in (("identify", {}), ("identify", {"recordings": ["a.csv"]}), ("identify", {"recordings": [], "method": "allan_noise"}),
                               ("identify", {"recordings": "a.csv", "method": "allan_noise"}), ("identify", []),
                               ("identify", {"recordings": ["a.csv"], "method": "dtg_centrifuge"}),
                               ("identify", {"recordings": ["../a.csv"], "method": "allan_noise"}),
                               ("identify", {"recordings": ["a.csv"], "method": "allan_noise", "set": ["calibration=/etc/passwd"]}),
                               ("noise", {"file": "a.csv", "from": 1, "to": 0, "channels": ["gyro.x"]}),
                               ("noise", {"file": "a.csv", "from": 0, "to": 1, "channels": []}),
                               ("convert", {"file": "a.csv", "to": "../b.h5"}), ("convert", {"file": "a.csv", "to": "b.mat"})):
                self.assertEqual(server.ask("POST", f"/api/jobs/{path}", json.dumps(body))[0], 400, f"{path} {body}")
            job = server.job(server.json("POST", "/api/jobs/noise", {"file": "a.csv", "from": 90, "to": 95, "channels": ["gyro.x"]})["job"])
            self.assertEqual(job["state"], "failed")
            self.assertIn("has no sample from 90 s to 95 s", job["problems"][0])
            self.assertEqual((job["errors"][0]["code"], job["errors"][0]["message"]), ("bad_data", job["problems"][0]))

    def test_cancel_and_begin_again_with_the_next_server(self):
        with Server() as server:
            slow(server)
            busy = [server.json("POST", "/api/jobs/identify", {"recordings": ["long.h5"], "method": "allan_noise"})["job"] for _ in range(3)]
            job = server.job(busy[0], ("running", "done"))
            self.assertEqual(job["state"], "running")
            server.job(busy[1], ("running",))
            self.assertEqual(server.json("POST", f"/api/jobs/cancel?id={busy[1]}", {})["cancelled"], True)
            self.assertEqual(server.job(busy[1])["state"], "cancelled")
            self.assertEqual(server.json("POST", f"/api/jobs/cancel?id={busy[1]}", {})["cancelled"], False)
            running = children(server.process.pid)
            self.assertTrue(running)
            server.stop(signal.SIGKILL)
            time.sleep(0.5)
            self.assertEqual([child for child in running if alive(child)], [], "a job outlived a server that was killed")
            with Server(folder=server.folder) as following:
                self.assertEqual(following.job(busy[0], ("running", "done"))["state"], "running")
                self.assertEqual(following.job(busy[1])["state"], "cancelled")
                for job in busy:
                    following.ask("POST", f"/api/jobs/cancel?id={job}")
                self.assertEqual(following.job(busy[2])["state"], "cancelled")

    def test_events_go_on_where_they_were(self):
        with Server() as server:
            csv_file(server.folder / "a.csv", 300)
            before = server.json("GET", "/api/jobs")["event"]
            job = server.job(server.json("POST", "/api/jobs/noise", {"file": "a.csv", "from": 90, "to": 95, "channels": ["gyro.x"]})["job"])
            first = events(server, before, 2)
            self.assertEqual([json.loads(event["data"])["id"] for event in first], [job["id"]] * 2)
            numbers = [int(event["id"]) for event in first]
            self.assertEqual(numbers, [before + 1, before + 2])
            later = events(server, numbers[0], 1)
            self.assertEqual(int(later[0]["id"]), numbers[1])
            self.assertEqual(events(server, 5, 1)[0]["event"], "reset")
            self.assertEqual(events(server, before + 10**6, 1)[0]["event"], "reset")


def slow(server):
    """A recording whose analysis takes many seconds."""
    random.seed(4)
    with open(server.scratch / "long.csv", "w") as file:
        file.write("gyro.x[deg/h]\n")
        for _ in range(400_000):
            file.write(f"{random.gauss(0, 1):.5f}\n")
    subprocess.run([PROGRAM, "--quiet", "convert", str(server.scratch / "long.csv"), "-o", str(server.folder / "long.h5"), "--set", "rate=100"],
                   check=True)


def children(process):
    text = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process)], capture_output=True, text=True).stdout
    return [int(word) for word in text.split()]


def alive(process):
    try:
        with open(f"/proc/{process}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def events(server, after, count):
    """The next `count` events behind number `after`."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=10)
    connection.request("GET", "/api/events", headers={"Authorization": f"Bearer {server.token}", "Last-Event-ID": str(after)})
    response = connection.getresponse()
    found, current = [], {}
    while len(found) < count:
        line = response.fp.readline().decode().rstrip("\n")
        if not line:
            if "data" in current:
                found.append(current)
            current = {}
        elif not line.startswith(":"):
            key, value = line.split(": ", 1)
            current[key] = value
    connection.close()
    return found


class Start(unittest.TestCase):
    def refused(self, *arguments):
        run = subprocess.run([PROGRAM, "serve", *arguments], capture_output=True, text=True, timeout=30)
        self.assertEqual(run.returncode, 2, run)
        return run.stderr

    def test_what_would_let_others_in_is_refused(self):
        self.assertIn("give --cert FILE --key FILE", self.refused(".", "--host", "0.0.0.0"))
        self.assertIn("--no-token", self.refused(".", "--host", "0.0.0.0", "--no-token", "--cert", "a", "--key", "b"))
        self.assertIn("belong together", self.refused(".", "--cert", "a"))
        self.assertIn("is no folder", self.refused("/nonexistent"))
        self.assertIn("--port 99999", self.refused(".", "--port", "99999"))
        self.assertIn("--cert a:", self.refused(".", "--port", "0", "--cert", "a", "--key", "b"))
        with Server() as server:
            self.assertIn(f"cannot listen at 127.0.0.1 port {server.port}", self.refused(".", "--port", str(server.port)))

    def test_no_token(self):
        with Server("--no-token") as server:
            self.assertIsNone(server.token)
            self.assertEqual(server.ask("GET", "/api/jobs")[0], 200)
            self.assertEqual(server.ask("GET", "/api/jobs", headers={"Host": f"evil.example:{server.port}"})[0], 421)

    def test_tls(self):
        with tempfile.TemporaryDirectory() as folder:
            key, certificate = f"{folder}/key.pem", f"{folder}/cert.pem"
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", certificate, "-days", "2",
                            "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"], check=True, capture_output=True)
            with Server("--host", "0.0.0.0", "--cert", certificate, "--key", key) as server:
                context = ssl.create_default_context(cafile=certificate)
                connection = http.client.HTTPSConnection("127.0.0.1", server.port, context=context, timeout=20)
                body = json.dumps({"token": server.token})
                connection.request("POST", "/api/session", body)
                response = connection.getresponse()
                self.assertEqual(response.status, 200)
                self.assertIn("; Secure", response.getheader("Set-Cookie"))
                response.read()
                connection.request("GET", "/app.js")  # the same connection
                self.assertEqual(connection.getresponse().status, 200)
                connection.close()
                self.assertNotIn(b" 200 ", server.raw(f"GET / HTTP/1.1\r\nHost: localhost:{server.port}\r\n\r\n".encode(), 3))


class Description(unittest.TestCase):
    def test_every_address_of_the_description_is_served(self):
        description = json.loads((ROOT / "web/openapi.json").read_text())
        with Server() as server:
            self.assertEqual(json.loads(server.ask("GET", "/openapi.json")[2]), description)
            for path, methods in description["paths"].items():
                for method in methods:
                    if path == "/api/events":
                        continue
                    status = server.ask(method.upper(), path)[0]
                    self.assertNotIn(status, (405, 500, 501), f"{method} {path}")
                    query = [parameter for parameter in methods[method].get("parameters", [])]
                    if status == 404:
                        self.assertTrue(query, f"{method} {path}")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
