"""Plans through the server, as a page asks for them.

    serve_plans_test.py PROGRAM REPOSITORY
"""

import json
import math
import pathlib
import subprocess
import sys
import time
import unittest

from serve_test import PROGRAM, Server

PLAN = """# A table that turns slowly.
title  = "Scale factor"
method = "gyro_scale_factor"
"""


def ready(name):
    return subprocess.run([PROGRAM, "init", name], capture_output=True, text=True, check=True).stdout


class Plans(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        (cls.server.folder / "sub").mkdir()
        (cls.server.folder / "sub/tumble.toml").write_text(ready("accelerometer_tumble"))
        (cls.server.folder / "station.toml").write_text("[station]\nname = 'x'\n")
        (cls.server.folder / "broken.toml").write_text("title = \n")

    @classmethod
    def tearDownClass(cls):
        cls.server.__exit__()

    def post(self, what, expect=(200,), **body):
        return self.server.json("POST", f"/api/plan/{what}", body, expect)

    def predicted(self, **body):
        for _ in range(600):
            status, _, content = self.server.ask("POST", "/api/plan/predict", json.dumps(body))
            if status != 202:
                return status, json.loads(content)
            time.sleep(0.05)
        raise AssertionError("the prediction never ends")

    def test_the_list_has_plans_and_templates(self):
        answer = self.server.json("GET", "/api/plans")
        plans = {plan["name"]: plan for plan in answer["plans"]}
        self.assertEqual(plans["sub/tumble.toml"]["rig"], "dividing_head")
        self.assertFalse({"station.toml", "broken.toml"} & plans.keys())
        names = [plan["name"] for plan in answer["templates"]]
        self.assertIn("imu_turntable", names)
        self.assertEqual(self.server.json("GET", "/api/plan?template=imu_turntable")["text"], ready("imu_turntable"))
        self.assertEqual(self.server.ask("GET", "/api/plan?template=none")[0], 404)
        self.assertEqual(self.server.ask("GET", "/api/plan?file=../x.toml")[0], 400)

    def test_the_catalogue_is_that_of_the_command_line(self):
        for kind in ("methods", "models", "rigs"):
            listed = json.loads(subprocess.run([PROGRAM, "list", kind, "--json"], capture_output=True, text=True, check=True).stdout)
            self.assertEqual([one["name"] for one in self.server.json("GET", f"/api/catalogue?kind={kind}")],
                             [one["name"] for one in listed])
            self.assertEqual(self.server.json("GET", f"/api/catalogue?kind={kind}&name={listed[0]['name']}"), listed[0])
        self.assertEqual(self.server.ask("GET", "/api/catalogue?kind=rigs&name=none")[0], 404)

    def test_problems_have_their_lines_all_at_once(self):
        text = ready("accelerometer_tumble").replace('kind = "dividing_head"', 'kind = "dividing_head"\nlevel_sd = "2 s"') + "\nbies = 1\n"
        answer = self.post("look", text=text, file="sub/tumble.toml")
        lines = text.splitlines()
        self.assertEqual([lines[problem["line"] - 1] for problem in answer["problems"]], ['level_sd = "2 s"', "bies = 1"])
        self.assertNotIn("tumble.toml", answer["problems"][0]["message"])
        self.assertIsNone(answer["schedule"])
        self.assertEqual(answer["document"]["rig"]["table"]["kind"]["text"], "dividing_head")
        answer = self.post("look", text="a = 1\nb = ", file="")
        self.assertEqual(answer["problems"][0]["line"], 2)
        self.assertIsNone(answer["document"])

    def test_the_schedule_is_a_timeline(self):
        answer = self.post("look", text=ready("dtg_centrifuge"), file="")
        self.assertEqual(answer["problems"], [])
        runs = answer["schedule"]["runs"]
        self.assertEqual([run["run"] for run in runs], [1, 2, 3])
        self.assertEqual([segment["begin"] for segment in runs[1]["segments"][:3]], [0, 600, 900])
        self.assertEqual(answer["schedule"]["total"], 3 * runs[0]["duration"])

    def test_an_edit_keeps_comments(self):
        text = self.post("edit", text=PLAN, change="set", path=["title"], value='a "b"')["text"]
        self.assertEqual(text, PLAN.replace('"Scale factor"', '"a \\"b\\""'))
        text = self.post("edit", text=PLAN, change="add", path=["limit"], value={"parameter": "bias", "max": "1 deg/h"})["text"]
        self.assertEqual(text, PLAN + '\n[[limit]]\nparameter = "bias"\nmax = "1 deg/h"\n')
        for wrong in ({"change": "no"}, {"change": "copy", "path": ["schedule", "x"]}, {"change": "copy", "path": ["schedule", "0"]},
                      {"change": "set", "path": []}, {"change": "set", "path": ["title"]}, {"change": "add", "path": ["a"], "value": 1}):
            self.assertEqual(self.server.ask("POST", "/api/plan/edit", json.dumps({"text": PLAN, **wrong}))[0], 400, wrong)

    def test_what_changed_on_the_disk_is_not_overwritten(self):
        file = self.server.folder / "mine.toml"
        tag = self.post("save", file="mine.toml", text=PLAN)["tag"]
        self.assertEqual(file.read_text(), PLAN)
        self.post("save", (409,), file="mine.toml", text="new")
        tag = self.post("save", file="mine.toml", text=PLAN + "# more\n", tag=tag)["tag"]
        file.write_text("of somebody else")
        self.assertIn("changed on the disk", self.post("save", (409,), file="mine.toml", text=PLAN, tag=tag)["problems"][0])
        self.assertEqual(file.read_text(), "of somebody else")
        file.unlink()
        self.post("save", (409,), file="mine.toml", text=PLAN, tag=tag)
        self.assertFalse(file.exists())
        for name in ("../x.toml", "/tmp/x.toml", "x.csv", ".x.toml", "none/x.toml", "sub/../x.toml", "", "x\n.toml"):
            self.post("save", (400, 404, 422), file=name, text=PLAN)

    def test_the_rig_stands_as_the_plan_says(self):
        # z up at first: the inner axis is x; a quarter of a turn about it puts y up
        text = ready("imu_turntable")
        begin = next(segment["begin"] for segment in self.post("look", text=text, file="")["schedule"]["runs"][0]["segments"]
                     if segment["label"] == "y up, heading 0")
        answer = self.post("motion", text=text, file="", run=1, **{"from": begin + 60, "step": 1, "count": 2})
        self.assertEqual([part["name"] for part in answer["parts"]], ["outer", "middle", "inner", "instrument"])
        self.assertEqual(answer["parts"][0]["axis"], [0, 0, 1])
        self.assertEqual(answer["parts"][3]["at"][0][3:6], [0, 0, 1], "y of the instrument is up")
        self.assertEqual(answer["gravity"], [0, 0, -9.797])
        latitude = math.radians(34.25)
        rate = answer["earth_rate"]
        self.assertAlmostEqual(rate[1] / 7.292115e-5, math.cos(latitude), delta=1e-6)
        self.assertAlmostEqual(rate[2] / 7.292115e-5, math.sin(latitude), delta=1e-6)
        self.assertIn({"name": "inner", "values": ["90.0 deg", "90.0 deg"]}, answer["axes"])
        arm = self.post("motion", text=ready("dtg_centrifuge"), file="", run=2, **{"from": 0, "step": 1, "count": 1})
        place = arm["parts"][1]["at"][0][9:12]
        self.assertAlmostEqual(math.hypot(*place), 2.5, delta=1e-5)
        for wrong in ({"run": 9}, {"count": 0}, {"count": 1e9}, {"from": "x"}):
            body = {"text": text, "run": 1, "from": 0, "step": 1, "count": 1, **wrong}
            self.assertEqual(self.server.ask("POST", "/api/plan/motion", json.dumps(body))[0], 400, wrong)

    def test_a_shorter_dwell_is_predicted_to_be_worse(self):
        text = ready("accelerometer_tumble")
        shorter = text.replace('"100 s"', '"40 s"')
        _, answer = self.predicted(page="a", text=text, saved=text, file="")
        self.assertEqual({row["saved"] for row in answer["rows"]}, {""})
        told = json.loads(subprocess.run([PROGRAM, "predict", str(self.server.folder / "sub/tumble.toml"), "--json"],
                                         capture_output=True, text=True, check=True).stdout)
        self.assertEqual([float(row["sd"]) for row in answer["rows"]],
                         [float(f"{one['sd']:.3g}") for one in told["parameters"]])
        _, answer = self.predicted(page="a", text=shorter, saved=text, file="")
        bias = next(row for row in answer["rows"] if row["name"] == "bias")
        self.assertEqual(bias["change"], "worse")
        self.assertGreater(float(bias["sd"]), float(bias["saved"]))
        self.assertGreater(answer["worse"], 0)
        _, answer = self.predicted(page="a", text=text, saved=shorter, file="")
        self.assertEqual(answer["worse"], 0)
        self.assertGreater(answer["better"], 0)

    def test_what_cannot_be_predicted_says_why(self):
        status, answer = self.predicted(page="b", text='title = "x"\n', saved="", file="")
        self.assertEqual((status, answer["rows"]), (200, []))
        self.assertTrue(answer["problems"])
        self.assertNotIn(str(self.server.folder), " ".join(answer["problems"]))

    def test_the_next_question_of_a_page_ends_the_one_before(self):
        text = ready("imu_turntable")
        for i in range(30):
            body = {"page": "c", "text": f"{text}\n# {i}\n", "saved": "", "file": ""}
            self.assertIn(self.server.ask("POST", "/api/plan/predict", json.dumps(body))[0], (200, 202))
        begin = time.monotonic()
        status, answer = self.predicted(page="c", text=text, saved="", file="")
        self.assertEqual((status, answer["problems"]), (200, []))
        children = pathlib.Path(f"/proc/{self.server.process.pid}/task/{self.server.process.pid}/children")
        self.assertLess(time.monotonic() - begin, 60)
        if children.exists():
            self.assertEqual(children.read_text().split(), [])

    def test_a_plan_is_rehearsed_and_optimised(self):
        (self.server.folder / "short.toml").write_text(ready("accelerometer_four_position"))
        jobs = {what: self.server.json("POST", "/api/jobs/plan", {"file": "short.toml", "what": what})["job"]
                for what in ("rehearse", "optimise")}
        rehearsed = self.server.job(jobs["rehearse"], seconds=120)
        self.assertEqual((rehearsed["state"], rehearsed["problems"]), ("done", []))
        self.assertIn("report.html", rehearsed["files"])
        optimised = self.server.job(jobs["optimise"], seconds=240)
        if optimised["state"] == "done":
            text = self.server.ask("GET", f"/api/jobs/file?id={jobs['optimise']}&name=optimised.toml")[2].decode()
            self.assertIn("[[schedule]]", text)
        else:
            self.assertTrue(optimised["problems"])
        self.assertEqual(self.server.ask("POST", "/api/jobs/plan", json.dumps({"file": "short.toml", "what": "no"}))[0], 400)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
