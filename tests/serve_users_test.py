"""Users, roles and signatures, as people of a laboratory and their enemies meet them.

    serve_users_test.py PROGRAM REPOSITORY
"""

import concurrent.futures
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from serve_test import PROGRAM, ROOT, Server


class Users(unittest.TestCase):
    """A laboratory with an archive and three users, as its people and its enemies meet it."""

    PASSWORDS = {"Li Wei": "correct horse 1", "R. Reader": "correct horse 2", "A. Approver": "correct horse 3"}
    ROLES = {"Li Wei": ["operate"], "R. Reader": ["read"], "A. Approver": ["approve"]}

    @classmethod
    def setUpClass(cls):
        cls.scratch = pathlib.Path(tempfile.mkdtemp(prefix="tumble-users-"))
        cls.users, cls.archive = cls.scratch / "users.toml", cls.scratch / "lab.db"
        for name, password in cls.PASSWORDS.items():
            roles = [word for role in cls.ROLES[name] for word in ("--role", role)]
            cls.call("serve", "--users", cls.users, "--add-user", name, *roles, text=password + "\n")
        plan, data, result = ROOT / "plans/static_bias.toml", cls.scratch / "a.h5", cls.scratch / "a.json"
        cls.call("archive", "init", "--archive", cls.archive, "--by", "test")
        cls.call("simulate", plan, "-o", data, "--seed", "1")
        cls.call("identify", plan, data, "-o", result, "--archive", cls.archive, "--by", "test")
        cls.sha256 = json.loads(cls.call("archive", "history", "demo-3", "--json", "--archive", cls.archive))["results"][0]["sha256"]

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.scratch)

    @classmethod
    def call(cls, *words, text="", status=0):
        done = subprocess.run([PROGRAM, "--quiet", *map(str, words)], input=text, text=True, capture_output=True)
        if done.returncode != status:
            raise AssertionError(f"{words}: {done.returncode} {done.stderr}")
        return done.stdout

    def server(self):
        return Server("--users", str(self.users), "--archive", str(self.archive))

    @staticmethod
    def post(server, path, body, cookie="", **headers):
        head = {**({"Cookie": cookie} if cookie else {}), **headers}
        return server.ask("POST", path, json.dumps(body), head)

    def sign_in(self, server, name, password=None):
        status, headers, content = self.post(server, "/api/session", {"name": name, "password": password or self.PASSWORDS[name]})
        self.assertEqual(status, 200, content)
        return headers["Set-Cookie"].split(";")[0]

    def test_each_does_what_the_roles_allow(self):
        signature = {"sha256": self.sha256, "meaning": "reviewed", "reason": "x", "password": "?"}
        with self.server() as server:
            self.assertIsNone(server.token)
            self.assertEqual(server.ask("GET", "/api/archive/units")[0], 401)
            self.assertEqual(self.post(server, "/api/session", {"token": ""})[0], 403)
            self.assertEqual(self.post(server, "/api/session", {"name": ["a"], "password": 1})[0], 400)
            allowed = {"R. Reader": (200, 403, 403), "Li Wei": (200, 202, 403), "A. Approver": (200, 403, 403)}
            for name, expected in allowed.items():
                cookie = self.sign_in(server, name)
                got = (server.ask("GET", "/api/archive/units", None, {"Cookie": cookie})[0],
                       self.post(server, "/api/archive/verify", {}, cookie)[0],
                       self.post(server, "/api/archive/sign", signature, cookie)[0])
                self.assertEqual(got, expected, name)
            # A body cannot make its sender somebody else, and the approver's own password signs.
            cookie = self.sign_in(server, "A. Approver")
            other = {**signature, "password": self.PASSWORDS["Li Wei"], "name": "Li Wei", "user": "Li Wei"}
            self.assertEqual(self.post(server, "/api/archive/sign", other, cookie)[0], 403)
            right = {**signature, "password": self.PASSWORDS["A. Approver"]}
            self.assertEqual(self.post(server, "/api/archive/sign", {**right, "sha256": "0" * 64}, cookie)[0], 400)
            self.assertEqual(self.post(server, "/api/archive/sign", {**right, "reason": ""}, cookie)[0], 400)
            self.assertEqual(self.post(server, "/api/archive/sign", right, cookie)[0], 201)
            self.assertEqual(self.post(server, "/api/archive/sign", right, cookie)[0], 400)
            record = json.loads(server.ask("GET", "/api/archive/unit?unit=demo-3", None, {"Cookie": cookie})[2])
            self.assertEqual([(one["by"], one["meaning"], one["problem"]) for one in record["signatures"]],
                             [("A. Approver", "reviewed", "")])
        self.call("archive", "verify", "--archive", self.archive)

    def test_no_address_answers_above_a_role(self):
        description = json.loads((ROOT / "web/openapi.json").read_text())
        everybody = {"", *self.PASSWORDS}
        with self.server() as server:
            cookies = {"": None, **{name: self.sign_in(server, name) for name in self.PASSWORDS}}
            for path, methods in description["paths"].items():
                for method, operation in methods.items():
                    if path in ("/api/events", "/api/session", "/api/session/end"):
                        continue
                    needed = operation.get("x-role", "read" if method == "get" else "operate")
                    is_open = not path.startswith("/api/") or path == "/api/texts"
                    may = everybody if is_open else {name for name in self.PASSWORDS if needed == "read" or needed in self.ROLES[name]}
                    for name, cookie in cookies.items():
                        status, _, content = server.ask(method.upper(), path, "{}" if method == "post" else None, {"Cookie": cookie} if cookie else {})
                        refused = status == 401 or (status == 403 and b"this needs the role" in content)
                        self.assertEqual(refused, name not in may, f"{method} {path} as {name or 'nobody'}: {status} {content[:100]}")

    def test_cookies_that_are_forged_or_of_others(self):
        with self.server() as server:
            cookie = self.sign_in(server, "A. Approver")
            name, secret = cookie.split("=")
            self.assertEqual(len(secret), 64)
            self.assertNotEqual(self.sign_in(server, "A. Approver"), cookie)
            flipped = secret[:-1] + ("0" if secret[-1] != "0" else "1")
            for forged in (f"{name}={flipped}", f"{name}=", f"{name}={secret}{secret}", f"x{name}={secret}", f"{name}=A. Approver",
                           f"{name}={'a' * 9000}", f"tumble_1={secret}"):
                self.assertEqual(server.ask("GET", "/api/jobs", None, {"Cookie": forged})[0], 401, forged[:60])
            for site in ({"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "cross-site"}, {"Sec-Fetch-Site": "same-site"}):
                self.assertEqual(self.post(server, "/api/archive/verify", {}, cookie, **site)[0], 403)
                self.assertEqual(self.post(server, "/api/session", {"name": "a", "password": "b"}, **site)[0], 403)
            self.assertEqual(self.post(server, "/api/session/end", {}, cookie)[0], 200)
            self.assertEqual(server.ask("GET", "/api/jobs", None, {"Cookie": cookie})[0], 401)

    def test_wrong_passwords_are_counted_and_written_nowhere(self):
        secret = "a wrong horse that stands nowhere"
        with self.server() as server:
            for name in ("Li Wei", "who is not there"):
                answers = [self.post(server, "/api/session", {"name": name, "password": secret}) for _ in range(6)]
                self.assertEqual([answer[0] for answer in answers], [403] * 5 + [429], name)
                self.assertGreater(int(answers[5][1]["Retry-After"]), 20)
            self.assertEqual(self.post(server, "/api/session", {"name": "Li Wei", "password": self.PASSWORDS["Li Wei"]})[0], 429)
            cookie = self.sign_in(server, "R. Reader")  # who has done nothing is not kept out
            self.assertEqual(server.ask("GET", "/api/session", None, {"Cookie": cookie})[0], 200)
            server.process.send_signal(signal.SIGTERM)
            said = server.process.stdout.read() + server.process.stderr.read()
            for place in [*server.scratch.rglob("*"), self.users, self.archive]:
                if place.is_file():
                    said += place.read_bytes().decode("latin-1")
            for password in (secret, *self.PASSWORDS.values()):
                self.assertNotIn(password, said)

    def test_who_is_there_and_who_is_not_take_as_long(self):
        """Processor time of the server: both calculate one scrypt, which is nearly all of it."""
        with self.server() as server:
            def spent():
                fields = pathlib.Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
                return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

            def cost(name):
                before = spent()
                for i in range(4):
                    self.post(server, "/api/session", {"name": name, "password": f"wrong {i}"})
                return spent() - before
            there, absent = cost("Li Wei"), cost("Li Wie")
            self.assertGreater(there, 0.2)  # four hashes
            self.assertLess(abs(there - absent), 0.3 * there)  # caches differ; without a hash the difference would be all of it

    def test_many_who_guess_at_once_keep_nobody_waiting(self):
        with self.server() as server:
            cookie = self.sign_in(server, "R. Reader")
            with concurrent.futures.ThreadPoolExecutor(12) as pool:
                guesses = [pool.submit(self.post, server, "/api/session", {"name": f"guess {i}", "password": "x"}) for i in range(24)]
                seen = [server.ask("GET", "/api/jobs", None, {"Cookie": cookie})[0] for _ in range(10)]
                self.sign_in(server, "A. Approver")
                statuses = {guess.result()[0] for guess in guesses}
            self.assertEqual(seen, [200] * 10)
            self.assertEqual(statuses, {403})  # one check at a time: the others wait for their turn

    def test_a_user_who_is_removed_is_out(self):
        own = self.scratch / "few.toml"
        shutil.copy(self.users, own)
        with Server("--users", str(own)) as server:
            cookie = self.sign_in(server, "A. Approver")
            text = own.read_text()
            own.write_text(text[:text.rindex("[[user]]")])
            os.utime(own, (2e9, 2e9))
            self.assertEqual(server.ask("GET", "/api/jobs", None, {"Cookie": cookie})[0], 401)

    def test_files_of_users_that_are_wrong(self):
        poor = self.scratch / "poor.toml"
        for text in ("", "[[user]]\nname = 'a'\nroles = ['root']\npassword = 'plain text'\n"):
            poor.write_text(text)
            poor.chmod(0o600)
            self.call("serve", ROOT / "docs", "--users", poor, "--port", "0", status=2)
        inside = subprocess.run([PROGRAM, "serve", self.scratch, "--users", self.users, "--port", "0"], text=True, capture_output=True)
        self.assertEqual(inside.returncode, 2)
        self.assertIn("keep it elsewhere", inside.stderr)
        for words in (["--add-user", "x"], ["--role", "read"], ["--add-user", "Li Wei", "--role", "read"], ["--password-of", "nobody"]):
            self.call("serve", "--users", self.users, *words, text="correct horse 9\n", status=2)
        self.call("serve", "--users", self.scratch / "new.toml", "--add-user", "x", "--role", "read", text="short\n", status=2)
        self.assertFalse((self.scratch / "new.toml").exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
