"""A folder that somebody else gave is data: nothing in it is run, and nothing outside of it is opened.

    serve_folder_test.py PROGRAM REPOSITORY
"""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.parse

from serve_stations_test import bench_files, read_if_there
from serve_test import PROGRAM, ROOT, Server, csv_file

SECRET = "WORD-OF-THE-SECRET"


def job_file(folder, number, state, steps, files=()):
    """What a job of an earlier version left, or what its enemy wrote."""
    place = folder / "jobs" / number
    place.mkdir(parents=True)
    (place / "job.json").write_text(json.dumps({"id": number, "kind": "convert", "title": "x", "state": state, "doing": "", "progress": 0.0,
                                                "begun": 0.0, "problems": [], "files": list(files), "steps": steps, "scratch": ""}))
    return place


class Given(unittest.TestCase):
    """A folder with everything in it that a workbench would like to believe."""

    def setUp(self):
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="tumble-given-"))
        self.folder, self.outside = self.scratch / "data", self.scratch / "home"
        self.folder.mkdir(parents=True)
        self.outside.mkdir()
        csv_file(self.folder / "a.csv", 400)
        self.plan = (ROOT / "plans/static_bias.toml").read_text()

    def tearDown(self):
        shutil.rmtree(self.scratch)

    def test_jobs_of_the_folder_are_not_carried_out(self):
        victim = self.outside / ".profile"
        victim.write_text("mine\n")
        steps = [["convert", str(self.folder / "a.csv"), "-o", str(self.outside / "made.h5")]]
        job_file(self.folder, "000001", "waiting", steps)
        job_file(self.folder, "000002", "running", [["convert", str(self.folder / "a.csv"), "-o", str(victim)]])
        job_file(self.folder, "000003", "done", [], ["/etc/passwd", "../../a.csv"])
        (self.folder / "jobs/000004").symlink_to(self.outside)
        with Server(folder=self.folder) as server:
            self.assertEqual(server.json("GET", "/api/jobs")["jobs"], [])
            for name in ("/etc/passwd", "../../a.csv", "job.json"):
                for number in ("000001", "000003", "000004"):
                    query = urllib.parse.urlencode({"id": number, "name": name})
                    self.assertEqual(server.ask("GET", f"/api/jobs/file?{query}")[0], 404)
            # A job of our own is behind all of these, and runs: by then the others would have, too.
            own = server.json("POST", "/api/jobs/convert", {"file": "a.csv", "to": "own.h5"})["job"]
            self.assertEqual(own, "000005")
            self.assertEqual(server.job(own)["files"], ["own.h5"])
            self.assertEqual([job["id"] for job in server.json("GET", "/api/jobs")["jobs"] if job["kind"] != "prepare"], [own])
            self.assertFalse((self.folder / "jobs" / own / "job.json").exists())
        self.assertEqual(victim.read_text(), "mine\n")
        self.assertEqual([path.name for path in self.outside.iterdir()], [".profile"])

    def test_a_job_of_another_server_is_known_by_its_folder(self):
        with Server(folder=self.folder) as server:
            own = server.json("POST", "/api/jobs/convert", {"file": "a.csv", "to": "own.h5"})["job"]
            server.job(own)
        query = urllib.parse.urlencode({"id": own, "name": "own.h5"})
        with Server(folder=self.folder) as server:
            self.assertEqual(server.json("GET", "/api/jobs")["jobs"][0]["files"], ["own.h5"])
            status, _, content = server.ask("GET", f"/api/jobs/file?{query}")
            self.assertEqual((status, content), (200, (self.folder / "jobs" / own / "own.h5").read_bytes()))
            (self.folder / "jobs" / own / "own.h5").rename(self.folder / "kept.h5")
            (self.folder / "jobs" / own / "own.h5").symlink_to("/etc/passwd")
            self.assertEqual(server.ask("GET", f"/api/jobs/file?{query}")[0], 404, "a link is no result")
        # The same name on another medium: what is in there is not the result of this job.
        shutil.move(self.folder / "jobs", self.scratch / "jobs of before")
        (self.folder / "jobs" / own).mkdir(parents=True)
        (self.folder / "jobs" / own / "own.h5").write_text("of somebody else")
        state = next(self.scratch.rglob(f"{own}.json"))
        job = json.loads(state.read_text())
        state.write_text(json.dumps({**job, "state": "running"}))
        with Server(folder=self.folder) as server:
            self.assertEqual(server.ask("GET", f"/api/jobs/file?{query}")[0], 404)
            self.assertEqual([(one["state"], one["problems"]) for one in server.json("GET", "/api/jobs")["jobs"] if one["id"] == own],
                             [("failed", ["the folder of this job was removed or replaced: start the job again"])])
        self.assertEqual((self.folder / "jobs" / own / "own.h5").read_text(), "of somebody else")

    def test_jobs_write_through_no_link(self):
        (self.folder / "jobs").symlink_to(self.outside)
        with Server(folder=self.folder) as server:
            status, _, content = server.ask("POST", "/api/jobs/convert", json.dumps({"file": "a.csv", "to": "own.h5"}))
            self.assertEqual(status, 507, content)
        self.assertEqual(list(self.outside.iterdir()), [])

    def secrets(self):
        """Files outside, each as its reader would like it, and links to them in the folder."""
        (self.outside / "device.toml").write_text(f'method = "{SECRET}"\n[instrument]\nmodel = "{SECRET}"\n')
        (self.outside / "result.json").write_text(json.dumps({"method": SECRET}))
        csv_file(self.outside / "data.csv", 400)
        shutil.copy(ROOT / "examples/logo.svg", self.outside / "logo.svg")
        for file in list(self.outside.iterdir()):
            (self.folder / f"link-{file.name}").symlink_to(file)
        (self.folder / "away").symlink_to(self.outside)

    def names_of(self, file):
        return [str(self.outside / file), f"../home/{file}", f"link-{file}", f"away/{file}", str(self.outside / ("no-" + file)),
                f"../home/no-{file}", f"away/no-{file}"]

    def problems(self, server, text):
        answer = server.json("POST", "/api/plan/look", {"text": text, "file": "p.toml"})
        problems = [problem["message"] for problem in answer["problems"]]
        for problem in problems:
            self.assertNotIn(SECRET, problem)
            self.assertNotIn(str(self.scratch), problem.replace(str(self.outside), "") if str(self.outside) in text else problem)
        return problems

    def test_plans_open_nothing_outside(self):
        self.secrets()
        recording = self.plan + '\n[[recording]]\nfile = "a.csv"\n'
        with Server(folder=self.folder) as server:
            for key, file, text in (("plan", "device.toml", recording + 'plan = "{}"\n'), ("file", "data.csv", self.plan + '\n[[recording]]\nfile = "{}"\n'),
                                    ("frames", "device.toml", recording + 'frames = "{}"\n'), ("prior", "result.json", 'prior = "{}"\n' + self.plan),
                                    ("calibration", "result.json", 'calibration = "{}"\n' + self.plan)):
                for name in self.names_of(file):
                    problems = self.problems(server, text.replace("{}", name))
                    said = f"'{name}' lies outside of the folder of the workbench: copy it into the folder"
                    self.assertTrue(any(said in problem for problem in problems), f"{key} {name}: {problems}")
            for pattern in ("/etc/pass*", "../home/*.csv", "away/*.csv"):
                problems = self.problems(server, self.plan + f'\n[[recording]]\nfile = "{pattern}"\n')
                self.assertTrue(any("lies outside" in problem or "no file is called like" in problem for problem in problems), problems)
            chinese = json.loads(server.ask("POST", "/api/plan/look?language=zh",
                                            json.dumps({"text": recording + 'plan = "/x.toml"\n', "file": "p.toml"}))[2])
            self.assertIn("不在工作台的文件夹内", json.dumps(chinese, ensure_ascii=False))

    def test_programs_that_the_server_starts_open_nothing_outside(self):
        self.secrets()
        (self.folder / "p.toml").write_text(self.plan + f'\n[[recording]]\nfile = "{self.outside}/data.csv"\n')
        bag = self.folder / "bag"
        bag.mkdir()
        (bag / "metadata.yaml").write_text("rosbag2_bagfile_information:\n  version: 4\n")
        (bag / "x.mcap").symlink_to(self.outside / "data.csv")
        with Server(folder=self.folder) as server:
            job = server.job(server.json("POST", "/api/jobs/identify", {"plan": "p.toml", "recordings": ["a.csv"]})["job"])
            self.assertEqual(job["state"], "failed")
            self.assertTrue(any("lies outside of the folder" in problem for problem in job["problems"]), job)
            status, answer = server.prepared("bag")
            self.assertEqual(status, 422)
            self.assertIn("leads out of the folder", json.dumps(answer))
        # On the command line a plan names what its user wants.
        done = subprocess.run([PROGRAM, "identify", self.folder / "p.toml", "--quiet", "-o", self.scratch / "r.json"], capture_output=True, text=True)
        self.assertNotIn("lies outside", done.stderr)

    def test_stations_and_laboratories_open_nothing_outside(self):
        self.secrets()
        shutil.copytree(ROOT / "stations/frames", self.folder / "frames")
        station = (ROOT / "stations/gyro_scale_factor.toml").read_text()
        (self.folder / "plan.toml").write_text((ROOT / "plans/gyro_scale_factor.toml").read_text())
        request = {"mode": "virtual", "plan": "plan.toml", "station": "bench.toml", "units": {"unit": "7"}, "who": "a test"}
        lab = (ROOT / "examples/lab.toml").read_text()
        with Server(folder=self.folder) as server:
            def dry_run(text):
                (self.folder / "bench.toml").write_text(text)
                return server.json("POST", "/api/station/dry-run", request)["problems"]
            self.assertEqual(dry_run(station), [])
            frames = next(line for line in station.splitlines() if line.startswith("frames"))
            controller = next(line for line in station.splitlines() if line.startswith("controller"))
            for name in self.names_of("device.toml"):
                for line, key in ((frames, "frames"), (controller, "controller")):
                    problems = dry_run(station.replace(line, f'{key} = "{name}"', 1))
                    self.assertTrue(any("lies outside of the folder" in problem for problem in problems), f"{key} {name}: {problems}")
                    self.assertNotIn(SECRET, str(problems))
            subprocess.run([PROGRAM, "simulate", ROOT / "plans/static_bias.toml", "-o", self.folder / "s.h5", "--seed", "1", "--quiet"], check=True)
            subprocess.run([PROGRAM, "identify", ROOT / "plans/static_bias.toml", self.folder / "s.h5", "-o", self.folder / "r.json", "--quiet"],
                           check=True)
            shutil.copy(ROOT / "examples/logo.svg", self.folder / "logo.svg")
            logo = next(line for line in lab.splitlines() if line.startswith("logo"))
            for name, status in [("logo.svg", 200), *((name, 400) for name in self.names_of("logo.svg"))]:
                (self.folder / "lab.toml").write_text(lab.replace(logo, f'logo = "{name}"'))
                got, _, content = server.ask("GET", "/api/archive/certificate/page?lab=lab.toml&result=r.json&number=1")
                self.assertEqual(got, status, f"{name}: {content[:300]}")

    def test_a_run_of_the_folder_leads_nowhere(self):
        run = self.folder / "runs/x"
        run.mkdir(parents=True)
        (run / "plan.toml").write_text(self.plan)
        (self.outside / "live.sqlite").write_bytes(b"")
        (run / "live.sqlite").symlink_to(self.outside / "live.sqlite")
        (run / "desk").symlink_to("/proc/self/fd/0")
        with Server(folder=self.folder) as server:
            status, _, content = server.ask("GET", "/api/station/run?run=runs/x")
            self.assertEqual(status, 422)
            self.assertIn(b"leads out of the folder", content)

    def test_a_live_store_names_nothing_outside(self):
        bench_files(self.folder)
        shutil.copy(self.folder / "bench.toml", self.outside / "bench.toml")
        with Server(folder=self.folder) as server:
            body = {"mode": "virtual", "plan": "plan.toml", "station": "bench.toml", "units": {"unit": "7"}, "who": "a test", "speed": "50"}
            run = server.json("POST", "/api/station/start", body)["run"]
            server.json("POST", "/api/station/order", {"run": run, "order": "stop"})
            for _ in range(600):
                if server.json("GET", f"/api/station/run?run={run}", expect=(200, 422)).get("alive") is False:
                    break
                time.sleep(0.1)
            for fact, value in (("station_file", self.outside / "bench.toml"), ("station_file", "../home/bench.toml"), ("target", self.outside / "made.h5")):
                with contextlib.closing(sqlite3.connect(self.folder / run / "live.sqlite")) as store:
                    before = store.execute("SELECT value FROM fact WHERE name = ?", (fact,)).fetchall()
                    store.execute("INSERT OR REPLACE INTO fact VALUES (?, ?)", (fact, str(value)))
                    store.commit()
                if fact == "station_file":
                    problems = server.json("POST", "/api/station/resume", {"run": run, "who": "a test", "speed": "50"}, expect=(422,))["problems"]
                    self.assertIn("lies outside of the folder of the workbench", problems[0])
                else:
                    environment = {**os.environ, "TUMBLE_CONFINED_TO": str(self.folder)}
                    done = subprocess.run([PROGRAM, "seal", self.folder / run], capture_output=True, text=True, env=environment)
                    self.assertIn("lies outside of the folder of the workbench", done.stderr)
                with contextlib.closing(sqlite3.connect(self.folder / run / "live.sqlite")) as store:
                    store.execute("DELETE FROM fact WHERE name = ?", (fact,))
                    store.executemany("INSERT INTO fact VALUES (?, ?)", [(fact, one[0]) for one in before])
                    store.commit()
        self.assertEqual([path.name for path in self.outside.iterdir()], ["bench.toml"])

    def killed_run(self):
        """What a run leaves whose process was killed."""
        bench_files(self.folder)
        with Server(folder=self.folder) as server:
            body = {"mode": "virtual", "plan": "plan.toml", "station": "bench.toml", "units": {"unit": "7"}, "who": "a test", "speed": "50"}
            run = server.json("POST", "/api/station/start", body)["run"]
            process = next(int(entry.name) for entry in pathlib.Path("/proc").iterdir()
                           if entry.name.isdigit() and f"-o\0{self.folder / run}\0".encode() in (read_if_there(entry / "cmdline") or b""))
            os.kill(process, signal.SIGKILL)
            while server.json("GET", f"/api/station/run?run={run}", expect=(200, 422)).get("alive") is not False:
                time.sleep(0.1)
        return run

    def test_runs_of_the_folder_write_through_no_link(self):
        run = self.killed_run()
        own = self.outside / "thesis.tex"
        own.write_text("years of work\n" * 1000)
        before = own.read_bytes()
        with Server(folder=self.folder) as server:
            for end in ("-wal", "-journal", "-shm"):
                copy = f"{run}{end}"
                shutil.copytree(self.folder / run, self.folder / copy, ignore=lambda *_: ["desk", "live.sqlite-wal"])
                (self.folder / copy / f"live.sqlite{end}").symlink_to(own)
                for method, path, body in (("GET", f"/api/station/run?run={copy}", None),
                                           ("POST", "/api/station/resume", {"run": copy, "who": "a test", "speed": "50"})):
                    problems = server.json(method, path, body, expect=(422,))["problems"]
                    self.assertEqual(problems, [f"'{copy}/live.sqlite{end}' is a link or a device, not a file: remove it"])
            chinese = server.json("GET", f"/api/station/run?run={run}-wal&language=zh", expect=(422,))["problems"][0]
            self.assertIn("请删除", chinese)
            reserve = self.folder / run / "reserve"
            reserve.unlink()
            reserve.symlink_to(own)
            problems = server.json("POST", "/api/station/resume", {"run": run, "who": "a test", "speed": "50"}, expect=(422,))["problems"]
            self.assertIn("reserve'", problems[0])
            reserve.unlink(missing_ok=True)
            log = self.folder / f"{run}.log"
            log.unlink()
            log.symlink_to(own)
            server.json("POST", "/api/station/resume", {"run": run, "who": "a test", "speed": "50"}, expect=(201,))
            self.assertFalse(log.is_symlink())
            server.json("POST", "/api/station/order", {"run": run, "order": "stop"})
            while server.json("GET", f"/api/station/run?run={run}").get("alive") is not False:
                time.sleep(0.1)
        self.assertEqual(own.read_bytes(), before)
        self.assertEqual([path.name for path in self.outside.iterdir()], [own.name])

    def test_an_upload_that_was_killed_leaves_nothing(self):
        with Server(folder=self.folder) as server:
            head = (f"POST /api/uploads?name=cut.csv HTTP/1.1\r\nHost: 127.0.0.1:{server.port}\r\nAuthorization: Bearer {server.token}\r\n"
                    "Content-Length: 5000\r\n\r\nhalf")
            client = socket.create_connection(("127.0.0.1", server.port))
            client.sendall(head.encode())
            for _ in range(200):
                if list((self.folder / "uploads").glob(".upload.*.part")):
                    break
                server.ask("GET", "/api/jobs")
            self.assertTrue(list((self.folder / "uploads").glob(".upload.*.part")))
            server.stop(signal.SIGKILL)
            client.close()
        (self.folder / "uploads/mine.part").write_text("x")
        with Server(folder=self.folder):
            self.assertEqual([path.name for path in (self.folder / "uploads").iterdir()], ["mine.part"])


class Places(unittest.TestCase):
    """Where the program keeps what is its own."""

    def test_folders_of_others_are_refused(self):
        with Server() as server:
            server.stop()
            places = server.scratch / "places"
            for variable in ("XDG_CACHE_HOME", "XDG_STATE_HOME"):
                (places / variable / "tumble").mkdir(parents=True)
                environment = {**os.environ, "XDG_CACHE_HOME": str(server.cache), "XDG_STATE_HOME": str(server.state), variable: str(places / variable)}
                (places / variable / "tumble").chmod(0o777)
                done = subprocess.run([PROGRAM, "serve", server.folder, "--port", "0"], capture_output=True, text=True, timeout=20, env=environment)
                self.assertEqual(done.returncode, 3, done)
                self.assertIn("others may write into", done.stderr)
                if os.geteuid() == 0:  # only root can give a folder to somebody else
                    (places / variable / "tumble").chmod(0o700)
                    os.chown(places / variable / "tumble", 12345, 12345)
                    done = subprocess.run([PROGRAM, "serve", server.folder, "--port", "0"], capture_output=True, text=True, timeout=20, env=environment)
                    self.assertEqual(done.returncode, 3, done)
                    self.assertIn("belongs to another user", done.stderr)

    def test_ways_to_read_a_recording_that_are_kept_are_few(self):
        with Server() as server:
            (server.folder / "x.csv").write_text("x[deg/h]\n" + "".join(f"{i % 7}\n" for i in range(500)))
            for rate in range(1, 13):
                self.assertEqual(server.prepared("x.csv", set=f"rate={rate}")[0], 200)
            self.assertEqual(len(list((server.cache / "tumble").glob("*.pyr"))), 8)
            self.assertEqual(server.prepared("x.csv", set="rate=1")[0], 200)

    def test_the_state_is_never_in_the_folder_that_is_shown(self):
        with Server() as scratch:
            scratch.stop()
            home = scratch.scratch / "home"
            home.mkdir()
            with Server(folder=home, environment={"XDG_STATE_HOME": str(home / ".state"), "TMPDIR": str(scratch.scratch)}):
                self.assertEqual(list(home.iterdir()), [])
                self.assertEqual(len(list(scratch.scratch.glob("tumble-state-*/workbenches/*"))), 1)

    def test_a_home_that_cannot_be_written_is_no_reason(self):
        with Server() as scratch:
            scratch.stop()
            nowhere = scratch.scratch / "file"
            nowhere.write_text("")  # for root, too: below a file there is no folder
            environment = {"HOME": str(nowhere / "home"), "XDG_STATE_HOME": "", "XDG_CACHE_HOME": "", "TMPDIR": str(scratch.scratch)}
            csv_file(scratch.folder / "a.csv", 100)
            with Server(folder=scratch.folder, environment=environment) as server:
                job = server.json("POST", "/api/jobs/convert", {"file": "a.csv", "to": "b.h5"})["job"]
                self.assertEqual(server.job(job)["state"], "done")
                self.assertEqual(server.prepared("a.csv")[0], 200)
            self.assertEqual(len(list(scratch.scratch.glob("tumble-state-*/workbenches/*/*.json"))), 1)

    def test_what_the_user_of_the_server_names_is_taken(self):
        """The folder by a link, links within it, and an archive that lies elsewhere, or is a link to elsewhere."""
        with Server() as scratch:
            scratch.stop()
            csv_file(scratch.folder / "a.csv", 400)
            (scratch.folder / "linked.csv").symlink_to("a.csv")
            (scratch.folder / "sub").mkdir()
            (scratch.folder / "sub/whole.csv").symlink_to(scratch.folder / "a.csv")
            by_link = scratch.scratch / "link"
            by_link.symlink_to(scratch.folder)
            archive = scratch.scratch / "lab.db"
            subprocess.run([PROGRAM, "archive", "init", "--archive", archive, "--by", "test"], check=True, capture_output=True)
            (scratch.folder / "lab.db").symlink_to(archive)
            plan = (ROOT / "plans/static_bias.toml").read_text() + "".join(f'\n[[recording]]\nfile = "{name}"\n' for name in ("linked.csv", "sub/whole.csv"))
            for named in (archive, scratch.folder / "lab.db"):
                with Server("--archive", str(named), folder=by_link) as server:
                    for name in ("a.csv", "linked.csv", "sub/whole.csv"):
                        self.assertEqual(server.prepared(name)[0], 200, name)
                    problems = server.json("POST", "/api/plan/look", {"text": plan, "file": "p.toml"})["problems"]
                    self.assertNotIn("folder of the workbench", json.dumps(problems))
                    self.assertEqual(server.json("GET", "/api/archive/units")["units"], [])
                    job = server.job(server.json("POST", "/api/archive/verify", {})["job"])
                    self.assertEqual(job["state"], "done", job)

    def test_files_that_are_missing_or_open_to_others_are_said(self):
        with Server() as server:
            folder = pathlib.Path(server.scratch)
            for users in (folder / "missing.toml", "-", folder):
                done = subprocess.run([PROGRAM, "serve", server.folder, "--port", "0", "--users", users], capture_output=True, text=True, timeout=20)
                self.assertEqual(done.returncode, 2, done)
                self.assertIn(f"--users {users}: there is no such file", done.stderr)
            key, certificate = folder / "key.pem", folder / "cert.pem"
            subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-keyout", key, "-out", certificate, "-days", "2",
                            "-subj", "/CN=localhost"], check=True, capture_output=True)
            key.chmod(0o644)
            done = subprocess.run([PROGRAM, "serve", server.folder, "--port", "0", "--cert", certificate, "--key", key], capture_output=True, text=True,
                                  timeout=20)
            self.assertEqual(done.returncode, 2, done)
            self.assertIn(f"chmod 600 {key}", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
