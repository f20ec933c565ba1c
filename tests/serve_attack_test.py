"""What the workbench answers to those who mean it no good: requests made from its own description, bytes that no browser
sends, a folder that is taken away.

    serve_attack_test.py PROGRAM REPOSITORY
"""

import collections
import json
import random
import shutil
import subprocess
import sys
import unittest
import urllib.parse

from serve_test import PROGRAM, ROOT, Server, csv_file

TEXTS = ["", "a.csv", "plan.toml", "..", "../../etc/passwd", "/etc/passwd", "a.csv/..", "a\nb", "x" * 300 + ".toml", "中文", "--help", "jobs",
         "{folder}/../x", "nan", "inf", "1e308", "-1", "0", "99999999999999999999", "null", "zh", "en", "deg/h", "kg^999999999", "((((", "a~b~c",
         "chart", "drift", "covariance", "methods", "static_bias", "\x7f", "\u202e"]
VALUES = [None, True, -1, 1e308, 2**64, 10**30, [], {}, [[]], [None], {"a": 1}, {"": ""}, ["a.csv"], "", [["x"]]]
ANYWHERE = {400, 401, 403, 404, 413, 421, 422, 429, 503, 507}  # as the description says of every address


def once(pairs):
    """An object of JSON whose names are all different."""
    double = [name for name, count in collections.Counter(name for name, _ in pairs).items() if count > 1]
    if double:
        raise AssertionError(f"twice: {double}")
    return dict(pairs)


class Description:
    """The addresses that web/openapi.json describes, with parameters and members of the body."""

    def __init__(self):
        self.text = json.loads((ROOT / "web/openapi.json").read_text(), object_pairs_hook=once)

    def whole(self, part):
        while "$ref" in part:
            kind, name = part["$ref"].split("/")[2:]
            part = self.text["components"][kind][name]
        return part

    def operations(self):
        for path, methods in self.text["paths"].items():
            for method, operation in methods.items():
                yield method.upper(), path, operation

    def parameters(self, operation):
        return [self.whole(one) for one in operation.get("parameters", [])]

    def members(self, operation):
        content = self.whole(operation.get("requestBody", {})).get("content", {})
        return content.get("application/json", {}).get("schema", {}).get("properties", {})


class Generated(unittest.TestCase):
    """Every address with parameters that are missing, wrong and extreme."""

    @classmethod
    def setUpClass(cls):
        cls.description = Description()
        cls.scratch = Server()
        cls.folder = cls.scratch.folder
        cls.scratch.stop()
        csv_file(cls.folder / "a.csv", 400)
        shutil.copy(ROOT / "plans/static_bias.toml", cls.folder / "plan.toml")
        archive = cls.scratch.scratch / "lab.db"
        subprocess.run([PROGRAM, "archive", "init", "--archive", archive, "--by", "test"], check=True, capture_output=True)
        cls.server = Server("--archive", str(archive), folder=cls.folder)

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()
        cls.scratch.__exit__()

    def check(self, method, path, operation, query=(), body=None):
        address = path + ("?" + urllib.parse.urlencode(query) if query else "")
        status, headers, content = self.server.ask(method, address, body)
        asked = f"{method} {address[:300]} {str(body)[:200]}: {status} {content[:300]}"
        self.assertIn(status, ANYWHERE | {int(code) for code in operation["responses"]}, asked)
        if status >= 400:
            problems = json.loads(content)["problems"]
            self.assertTrue(problems and all(isinstance(text, str) and text for text in problems), asked)
            self.assertNotIn(str(self.folder), content.decode(), asked)
        elif headers["Content-Type"] == "application/json":
            json.loads(content)

    def test_every_address_answers_as_it_is_described(self):
        chance = random.Random(20261127)
        for method, path, operation in self.description.operations():
            if path.endswith("/events"):
                continue
            members = self.description.members(operation)
            self.check(method, path, operation)
            for _ in range(6):
                query = [(parameter["name"], chance.choice(["a.csv", *TEXTS])) for parameter in self.description.parameters(operation)
                         if chance.random() < 0.85]
                body = {name: chance.choice(TEXTS + VALUES) for name in members if chance.random() < 0.85}
                if body.get("mode") in TEXTS:
                    body["mode"] = "rehearse"
                self.check(method, path, operation, query, json.dumps(body) if members else None)
        self.assertIsNone(self.server.process.poll())

    def test_bodies_that_are_nested_deeply_are_refused(self):
        for method, path, operation in self.description.operations():
            for name in self.description.members(operation):
                for begin, end in (("[", "]"), ('{"a":', "}")):
                    body = f'{{"{name}":{begin * 9000}1{end * 9000}}}'
                    self.check(method, path, operation, (), body)
        # A plan may be long enough to exhaust the stack of what writes its values.
        plan = json.dumps({"text": "a = 1\n", "change": "set", "path": ["a"]})[:-1]
        for begin, end in (("[", "]"), ('{"a":', "}")):
            status, _, content = self.server.ask("POST", "/api/plan/edit", f'{plan},"value":{begin * 150000}1{end * 150000}}}')
            self.assertEqual((status, json.loads(content)["problems"]), (400, ["the body is nested deeper than 64 levels"]))
        content = self.server.ask("POST", "/api/plan/edit?language=zh", f'{plan},"value":{"[" * 99}1{"]" * 99}}}')[2]
        self.assertEqual(json.loads(content)["problems"], ["正文嵌套超过 64 层"])


class Bytes(unittest.TestCase):
    """Heads and bodies that no browser sends."""

    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        csv_file(cls.server.folder / "a.csv", 40000)
        cls.server.prepared("a.csv")
        cls.host = f"Host: 127.0.0.1:{cls.server.port}\r\n"
        cls.own = f"{cls.host}Authorization: Bearer {cls.server.token}\r\n"

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    def asked(self, line, head, body="", wait=5.0):
        received = self.server.raw(f"{line}\r\n{head}\r\n{body}".encode(), wait)
        head, _, body = received.partition(b"\r\n\r\n")
        return int(head[9:12] or 0), head.decode(), body

    def test_what_is_said_twice_is_refused(self):
        line = "GET /api/workbench HTTP/1.1"
        close = "Connection: close\r\n"
        self.assertEqual(self.asked(line, self.own + close)[0], 200)
        own_origin = f"Origin: http://127.0.0.1:{self.server.port}\r\n"
        for double in (f"{self.host}Authorization: Bearer 0\r\nAuthorization: Bearer {self.server.token}\r\n",
                       f"{self.own}Origin: http://evil.example\r\n{own_origin}",
                       f"{self.own}Sec-Fetch-Site: cross-site\r\nSec-Fetch-Site: same-origin\r\n", f"{self.own}{self.host}"):
            self.assertEqual(self.asked(line, double + close)[0], 400, double)

    def test_codings_of_a_body_that_are_not_taken_off_are_refused(self):
        for coding in ("gzip", "gzip, chunked", "chunked, chunked", "identity"):
            status, head, body = self.asked("POST /api/jobs/noise HTTP/1.1", f"{self.own}Transfer-Encoding: {coding}\r\n", "2\r\n{}\r\n0\r\n\r\n")
            self.assertEqual(status, 400, coding)
            self.assertIn("close", head)
            self.assertEqual(json.loads(body), {"problems": ["the request is not well formed"]})

    def test_http_1_0_gets_no_chunks(self):
        line = "/api/recording/csv?file=a.csv&from=0&to=399"
        status, head, old = self.asked(f"GET {line} HTTP/1.0", self.own)
        self.assertEqual(status, 200)
        self.assertNotIn("chunked", head)
        self.assertEqual(old, self.server.ask("GET", line)[2])
        self.assertEqual(old.count(b"\n"), 1 + 39901)

    def test_head_states_no_length_that_get_has_not(self):
        status, head, body = self.asked("HEAD /api/recording/csv?file=a.csv&from=0&to=1 HTTP/1.1", self.own)
        self.assertEqual((status, body), (200, b""))
        self.assertNotIn("content-length", head.lower())

    def test_numbers_of_events_that_nobody_gave(self):
        for number in ("abc", "-1", "1.5", "99999999999999999999", "9" * 5000):
            received = self.server.raw(f"GET /api/events HTTP/1.1\r\n{self.own}Last-Event-ID: {number}\r\n\r\n".encode(), 1.0)
            self.assertIn(b"event: reset", received, number[:30])
        self.assertNotIn(b"event:", self.server.raw(f"GET /api/events HTTP/1.1\r\n{self.own}\r\n".encode(), 1.0))


class Folder(unittest.TestCase):
    """The folder is another's, goes away, or cannot be written."""

    def test_two_workbenches_do_not_share_a_folder(self):
        with Server() as server:
            second = subprocess.run([PROGRAM, "serve", server.folder, "--port", "0"], capture_output=True, text=True, timeout=20)
            self.assertEqual(second.returncode, 2)
            self.assertRegex(second.stderr, "another workbench serves '.*': use its link, or end it")
            second = subprocess.run([PROGRAM, "--lang", "zh", "serve", server.folder, "--port", "0"], capture_output=True, text=True, timeout=20)
            self.assertEqual(second.stderr, f"错误：文件夹“{server.folder}”正由另一个工作台使用：请用其链接打开，或按 Ctrl+C 结束它\n")
            self.assertEqual(server.ask("GET", "/api/jobs")[0], 200)

    def test_a_folder_that_went_away_is_said_and_not_made_again(self):
        with Server() as server:
            csv_file(server.folder / "a.csv", 100)
            moved = server.folder.with_name("moved")
            server.folder.rename(moved)
            for method, path, body in (("GET", "/api/recordings", None), ("GET", "/api/results", None), ("POST", "/api/uploads?name=x.csv", b"x"),
                                       ("POST", "/api/plan/save", b'{"file": "x.toml", "text": "a = 1"}')):
                status, _, content = server.ask(method, path, body)
                self.assertEqual((status, json.loads(content)["problems"]),
                                 (503, ["the folder of the workbench was removed or has another name now"]), path)
            content = server.ask("GET", "/api/results?language=zh")[2]
            self.assertEqual(json.loads(content)["problems"], ["工作台的文件夹已被删除或改名"])
            self.assertFalse(server.folder.exists())
            self.assertEqual(server.ask("GET", "/")[0], 200)
            moved.rename(server.folder)
            self.assertEqual(server.json("GET", "/api/recordings")["recordings"][0]["name"], "a.csv")

    def test_a_folder_that_cannot_be_written_is_said(self):
        with Server() as server:
            shutil.copy(ROOT / "plans/static_bias.toml", server.folder / "plan.toml")
            for name in ("jobs", "runs"):  # a file where a folder is needed: root too cannot write there
                (server.folder / name).write_text("")
            for path, body in (("/api/jobs/plan", {"file": "plan.toml", "what": "rehearse"}),
                               ("/api/station/start", {"mode": "rehearse", "plan": "plan.toml"})):
                status, _, content = server.ask("POST", path, json.dumps(body))
                self.assertEqual(status, 507, content)
                self.assertRegex(json.loads(content)["problems"][0], "^the folder cannot be written: ")
                self.assertNotIn(str(server.folder), content.decode())
                content = server.ask("POST", path + "?language=zh", json.dumps(body))[2]
                self.assertEqual(json.loads(content)["problems"], ["无法写入工作台的文件夹：不是文件夹"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
