"""The program in Chinese, as its users meet it: what people read changes with the language, files and JSON never do.

    languages_test.py PROGRAM REPOSITORY
"""

import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import unicodedata
import unittest

PROGRAM, ROOT = sys.argv[1], pathlib.Path(sys.argv[2])
DATA = ROOT / "examples/data/mpu6050_static.csv"
HAN = re.compile(r"[\u4e00-\u9fff]")


def tumble(*arguments, folder=None, **environment):
    """Standard output. The environment has no locale but the given."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("LC_", "LANG"))}
    done = subprocess.run([PROGRAM, *map(str, arguments)], cwd=folder, env={**kept, **environment}, capture_output=True, text=True,
                          encoding="utf-8", check=False)
    if done.returncode != 0:
        raise AssertionError(f"{arguments}: status {done.returncode}: {done.stderr}")
    return done.stdout


def entries_with_options():
    return [(kind, entry) for kind in ("methods", "models", "rigs") for entry in json.loads(tumble("list", kind, "--json"))]


def width(text):
    return sum(2 if unicodedata.east_asian_width(one) in "WF" else 1 for one in text)


def tables(text):
    """Heading, rule and rows of each table."""
    lines = text.split("\n")
    for i, line in enumerate(lines):
        if re.fullmatch(r"  ─+", line):
            end = next((k for k in range(i, len(lines)) if not lines[k].strip()), len(lines))
            yield lines[i - 1], line, lines[i + 1:end]


class Problems(unittest.TestCase):
    def test_a_wrong_option_goes_to_who_has_started_the_program_as_values(self):
        for arguments, pattern in ((["inspect"], "{} (see `tumble {}--help`)"), (["inspect", "--sett", "a=b"], "unknown option '{}'{} (see `tumble {}--help`)")):
            read, write = os.pipe()
            with open(read) as lines:
                done = subprocess.run([PROGRAM, *arguments], env={**os.environ, "TUMBLE_PROBLEMS": str(write)}, pass_fds=[write],
                                      capture_output=True, text=True, check=False)
                os.close(write)
                problem = json.loads(lines.readline().removeprefix("problems "))[0]
            self.assertEqual((done.returncode, problem["code"], problem["pattern"]), (2, "bad_input", pattern))
            self.assertEqual(done.stderr, f"error: {problem['message']}\n")


class Choice(unittest.TestCase):
    def is_chinese(self, *arguments, **environment):
        return "诊断信息" in tumble("inspect", DATA, *arguments, **environment)

    def test_option_and_environment(self):
        self.assertFalse(self.is_chinese())
        self.assertTrue(self.is_chinese("--lang", "zh"))
        self.assertTrue(self.is_chinese("--lang=zh"))
        self.assertTrue(self.is_chinese(LANG="zh_CN.UTF-8"))
        self.assertTrue(self.is_chinese(LANG="en_US.UTF-8", LC_MESSAGES="zh_CN.UTF-8"))
        self.assertFalse(self.is_chinese(LANG="zh_CN.UTF-8", LC_ALL="C.UTF-8"))
        self.assertFalse(self.is_chinese("--lang", "en", LANG="zh_CN.UTF-8"))

    def test_an_unknown_language_is_refused(self):
        done = subprocess.run([PROGRAM, "list", "--lang", "fr"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("{en,zh}", done.stderr)


class Reading(unittest.TestCase):
    """What people read."""

    def test_help(self):
        text = tumble("--lang", "zh", "--help")
        verbs = re.findall(r"^  ([a-z][a-z-]+) {2,}(.+)$", text, re.MULTILINE)
        self.assertGreater(len(verbs), 20)
        for verb, summary in verbs:
            self.assertRegex(summary, HAN, verb)
            self.assertIn(summary, tumble("help", verb, LANG="zh_CN.UTF-8"))
        self.assertNotIn("Options", text)

    def test_every_argument_of_every_verb(self):
        argument = re.compile(r"^  (\S+)[^\n]*(?:\n {20,}[^\n]*)*", re.MULTILINE)
        for verb in re.findall(r"^  ([a-z][a-z-]+) {2,}", tumble("--help"), re.MULTILINE):
            english, chinese = tumble("help", verb), tumble("help", verb, "--lang", "zh")
            for text in argument.finditer(chinese.partition("Example")[0].partition("\n\n")[2]):
                if (verb, text[1]) != ("station", "WHAT"):  # "check", a word of the command
                    self.assertRegex(text[0], HAN, f"{verb} {text[1]}")
            names = [sorted(m[1] for m in argument.finditer(text.partition("Example")[0].partition("\n\n")[2])) for text in (english, chinese)]
            self.assertEqual(*names)
        for kinds in (r"one of ((?:\w+, )+\w+)", r"note: one of ((?:\w+, )+\w+)"):
            for word in re.search(kinds, tumble("help", "archive"))[1].split(", "):
                self.assertIn(word + "（", tumble("help", "archive", "--lang", "zh"))

    def test_options_of_every_method_model_and_rig_and_the_line_of_every_entry(self):
        for kind in ("methods", "models", "rigs", "formats", "checks", "departures"):
            for line in tumble("list", kind, "--lang", "zh").splitlines():
                self.assertRegex(line, HAN)
        for kind, entry in entries_with_options():
            page = re.sub(r"\n {6,}", "\t", tumble("list", kind, entry["name"], "--lang", "zh").partition("选项：")[2])
            said = dict(re.findall(r"^  (\w+)  .*?\t(.*)$", page, re.MULTILINE))
            for option in entry["options"]:
                self.assertRegex(said[option["name"]], HAN, f"option.{entry['name']}.{option['name']} of text/zh.toml")

    def test_a_text_for_several_entries_says_what_each_says_in_english(self):
        chinese = tomllib.loads((ROOT / "text/zh.toml").read_text(encoding="utf-8"))["option"]
        english = {}
        for _, entry in entries_with_options():
            own = chinese.get(entry["name"], {})
            for option in entry["options"]:
                if option["name"] not in own:
                    english.setdefault(option["name"], set()).add(option["description"])
            self.assertLessEqual(own.keys(), {option["name"] for option in entry["options"]}, entry["name"])
        self.assertEqual({name for name, texts in english.items() if len(texts) > 1}, set())
        self.assertEqual(set(chinese["common"]), set(english))

    def test_tables_line_up(self):
        """The heading ends where its column does: every line of a table whose last column is lined up right ends with the rule."""
        text = tumble("inspect", DATA, "--lang", "zh")
        found = list(tables(text))
        self.assertGreater(len(found), 0)
        for heading, rule, rows in found:
            for line in [heading, *rows]:
                self.assertEqual(width(line), width(rule), line)

    def test_lines_are_no_wider_than_they_may_be(self):
        for line in tumble("identify", "allan_noise", DATA, "--lang", "zh").split("\n"):
            self.assertLessEqual(width(line), 100, line)

    def test_a_result_has_no_plus_minus(self):
        text = tumble("identify", "static_bias", DATA, "--set", "channels.signal=gyro.x", "--lang", "zh")
        self.assertIn("标准不确定度 u", text)
        self.assertNotIn("±", text)


class Results(unittest.TestCase):
    """Words of a result: every method is asked by chinese_results_test.cpp, here as its users read them."""

    ENGLISH = re.compile(r"[a-z]{3,} [a-z]{3,}")
    COMMAND = "tumble list departures"

    def test_terminal_page_and_drawing(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            tumble("init", "frequency_response", "-o", "plan.toml", folder=folder)
            tumble("simulate", "plan.toml", "-o", "data.h5", folder=folder)
            text = tumble("identify", "plan.toml", "data.h5", "-o", "result.json", "--lang", "zh", folder=folder)
            printed = tumble("identify", "plan.toml", "data.h5", "--lang", "zh", folder=folder)
            self.assertNotRegex((text + printed).replace(self.COMMAND, ""), self.ENGLISH)
            self.assertIn("表 频率特性（bode）：增益和相位", printed)
            self.assertIn("参考噪声", printed)
            tumble("report", "result.json", "-o", "page.html", "--figure", "drawing.svg", LANG="zh_CN.UTF-8", folder=folder)
            tumble("report", "result.json", "-o", "english.html", "--language", "en", LANG="zh_CN.UTF-8", folder=folder)
            page, english = ((folder / file).read_text(encoding="utf-8") for file in ("page.html", "english.html"))
            body = re.sub(r"<(style|code|pre)>.*?</\1>", "", page.split('<section id="provenance">')[0], flags=re.DOTALL)
            for said in re.findall(r">([^<]+)<", body) + re.findall(r'(?:title|aria-label)="([^"]+)"', body):
                self.assertNotRegex(said.replace(self.COMMAND, ""), self.ENGLISH)
            self.assertIn("<h1>伺服加速度计频率响应</h1>", page)
            self.assertNotRegex(re.sub(r"<pre>.*?</pre>", "", english, flags=re.DOTALL), HAN)
            for drawing in folder.glob("drawing*.svg"):
                texts = re.findall(r"<text[^>]*>([^<]*[A-Za-z\u4e00-\u9fff][^<]*)</text>", drawing.read_text(encoding="utf-8"))
                self.assertTrue(any(HAN.search(one) for one in texts))
                for one in texts:
                    self.assertNotRegex(one, self.ENGLISH)


def refusal(*arguments, **environment):
    """What a command that is refused says on standard error, problem by problem, and its status."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("LC_", "LANG"))}
    done = subprocess.run([PROGRAM, *map(str, arguments)], env={**kept, **environment}, capture_output=True, text=True,
                          encoding="utf-8", check=False)
    return done.stderr, done.returncode


class Refusals(unittest.TestCase):
    """What a newcomer meets first: no line of it is English, and the status is that of every language."""

    SENTENCE = re.compile(r"[a-z]+(?: [a-z]+){3,}")

    def test_first_errors(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "words.csv").write_text("time[s],gyro[deg/h]\n0,1\n1,two\n2,3\n")
            (folder / "bare.csv").write_text("time[s],x\n0,1\n1,2\n")
            (folder / "plan.toml").write_text('titel = "x"\n[instrument]\nrate = 1\n[site]\nlatitude = "3 m"\n')
            for arguments in (["identfy"], ["list", "metods"], ["list", "methods", "alan"], ["list", "--jsn"], ["convert", "a", "b"],
                              ["identify", "alan_noise", DATA], ["inspect", folder / "none.csv"], ["inspect", folder],
                              ["inspect", folder / "words.csv"], ["inspect", folder / "bare.csv"], ["identify", folder / "plan.toml"],
                              ["convert", DATA], ["convert", DATA, "-o", "x.xls"], ["convert", DATA, "-o", DATA], ["init", "statik_bias"],
                              ["identify", "static_bias", DATA, "--set", "channels.gyr=x"], ["station", "chek", "x"],
                              ["archive", "list", "--archive", folder / "no.db"], ["archive", "lst"],
                              ["inspect", DATA, "--set", "rate=fast"], ["inspect", DATA, "--set", "unit.x=deg/hous"]):
                english, status = refusal(*arguments)
                chinese, same = refusal(*arguments, LANG="zh_CN.UTF-8")
                self.assertIn(status, (2, 3), arguments)
                self.assertEqual(status, same)
                self.assertEqual(len(english.splitlines()), len(chinese.splitlines()))
                self.assertTrue(chinese.startswith("错误："), chinese)
                for line in chinese.splitlines():
                    self.assertRegex(line, HAN)
                    self.assertNotRegex(line, self.SENTENCE)


class Names(unittest.TestCase):
    """A name and a value are never translated, in no language; a sentence is translated whole or not at all."""

    NAMES = ("rig 3.csv", "line 2.csv", "model B.csv", "limits of unit 4.csv", "below 20 degC.csv")

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def both(self, *arguments):
        """What is refused, in English and in Chinese."""
        return [refusal(*arguments, LANG=code)[0].replace(f"{self.folder}/", "").splitlines() for code in ("C", "zh_CN.UTF-8")]

    def test_a_name_in_a_refusal(self):
        for name in self.NAMES:
            english, chinese = self.both("inspect", self.folder / name)
            self.assertEqual(english, [f"error: cannot read '{name}': No such file or directory"])
            self.assertEqual(chinese, [f"错误：无法读取“{name}”：没有该文件或文件夹"])

    def test_a_name_in_a_note(self):
        for name in self.NAMES:
            for code, said in (("C", f"tumble: wrote {name}"), ("zh_CN.UTF-8", f"tumble: 已写入 {name}")):
                done = subprocess.run([PROGRAM, "convert", DATA, "-o", name], cwd=self.folder, capture_output=True, text=True, encoding="utf-8",
                                      env={**os.environ, "LC_ALL": code}, check=True)
                self.assertEqual(done.stderr.splitlines()[-1], said)
                (self.folder / name).unlink()

    def test_a_cell_that_is_no_number_and_a_row_too_long(self):
        for name in self.NAMES:
            (self.folder / name).write_text("time[s],gyro[deg/h]\n0,1\n1,x\n2,3,4\n")
            english, chinese = self.both("inspect", self.folder / name)
            self.assertEqual(english[:3], [f"error: '{name}': 2 places that cannot be read", "       line 3, column 2 'gyro': 'x' is not a number",
                                           "       line 4: 3 cells instead of 2"])
            self.assertEqual(chinese[:3], [f"错误：“{name}”：有 2 处无法读取", "      第 3 行第 2 列“gyro”：“x”不是数值",
                                           "      第 4 行：有 3 个单元格，应为 2 个"])

    def test_a_wrong_unit_in_a_plan(self):
        for name in self.NAMES:
            plan = self.folder / name.replace(".csv", ".toml")
            plan.write_text('method = "static_bias"\n[site]\nlatitude = "1 parsec"\n')
            english, chinese = self.both("identify", plan)
            self.assertEqual(english[0], f"error: {plan.name}:3: [site]: latitude: unit 'parsec', position 1: unknown unit 'parsec'; "
                                         "did you mean 'parcsec'?")
            self.assertEqual(chinese[0], f"错误：{plan.name}:3：[site]：latitude：单位“parsec”第 1 个字符处：无法识别的单位“parsec”，是否应为“parcsec”？")

    def test_a_name_that_is_words_of_a_table(self):
        """Channels, paths, keys and options that are called like a sentence of the program or of the system."""
        (self.folder / "nu.csv").write_text("time[s],no unit[deg/s],File exists[deg/s]\n0,1,1\n1,2,1\n")
        good = self.folder / "good.csv"
        good.write_text("time[s],gyro[deg/s]\n0,1\n1,2\n2,3\n")
        for arguments, kept in ((["convert", self.folder / "nu.csv", "-o", self.folder / "y.csv", "--channel", "zz"], ("no unit", "File exists")),
                                (["convert", good, "-o", "Permission denied/x.csv"], ("Permission denied",)),
                                (["convert", good, "-o", "my test data/x.csv"], ("my test data",)),
                                (["identify", "allan_noise", good, "-o", "File exists"], ("File exists",)),
                                (["inspect", good, "--set", "File exists=1"], ("File exists",)),
                                (["record", "kvh_1775", "--link", "tcp:x", "-o", self.folder / "r.h5"], ("tcp",)),
                                (["record", "kvh_1775", "--link", "tcp:x:1", "--for", "3 m", "-o", self.folder / "r.h5"], ("--for 3 m",))):
            chinese = "\n".join(self.both(*arguments)[1])
            for name in kept:
                self.assertIn(name, chinese)
                chinese = chinese.replace(name, "")
            self.assertRegex(chinese, HAN)
            self.assertNotRegex(chinese, Refusals.SENTENCE)

    def test_a_sentence_with_a_place_or_a_count_is_chinese_whole(self):
        noheader = self.folder / "noheader.csv"
        noheader.write_text("0,1\n1,2\n2,3\n")
        good = self.folder / "good.csv"
        good.write_text("time[s],gyro[deg/s]\n" + "".join(f"{k / 100},{k % 7}\n" for k in range(50)))
        for arguments, said in ((["inspect", noheader], "“noheader.csv”第 1 行：表头处是数值（2 列）"),
                                (["inspect", good, "--set", "columns=time[s],x[deg/s],y[m]"], "“good.csv”第 1 行：有 2 列，而 columns 命名了 3 列"),
                                (["inspect", good, "--set", "rate=500"], "--set rate：good.csv 自带"),
                                (["identify", "static_bias", good, "--set", "axis=foo"], "方法 static_bias"),
                                (["identify", "allan_noise", good, "--set", "channels.signal=foo"], "good.csv：找不到用作 signal（"),
                                (["list", "units", "foo", "bar"], "多余的参数“bar”（参见 `tumble list --help`）"),
                                (["inspect"], "缺少 RECORDING（参见 `tumble inspect --help`）"),
                                (["list", "methods", "allan_nois"], "methods 中没有“allan_nois”，是否应为“allan_noise”？（可用的有")):
            english, chinese = self.both(*arguments)
            self.assertIn(said, chinese[0])
            for line in chinese:
                self.assertNotRegex(line, Refusals.SENTENCE)
            self.assertEqual(len(english), len(chinese))

    def test_a_result_in_a_folder_with_a_blank_can_be_computed_again(self):
        data = self.folder / "my data"
        data.mkdir()
        tumble("init", "static_bias", "-o", "plan.toml", folder=self.folder)
        tumble("simulate", "plan.toml", "--seed", "1", "-o", "my data/rec.h5", folder=self.folder)
        tumble("archive", "init", "--archive", "a.db", folder=self.folder)
        tumble("identify", "../plan.toml", "rec.h5", "--archive", "../a.db", "--by", "tester", "-o", "r.json", folder=data)
        sha256 = hashlib.sha256((data / "r.json").read_bytes()).hexdigest()
        for code in ("en", "zh"):  # another status is an AssertionError
            tumble("archive", "recompute", sha256, "--archive", "../a.db", "--by", "tester", "--lang", code, folder=data)


class Files(unittest.TestCase):
    """What programs read."""

    def test_json_is_the_same(self):
        for arguments in (["inspect", DATA, "--json"], ["list", "methods", "--json"], ["list", "rigs", "shaker", "--json"],
                          ["identify", "allan_noise", DATA, "--json"]):
            self.assertEqual(tumble(*arguments), tumble(*arguments, LANG="zh_CN.UTF-8"), arguments)

    def test_files_are_the_same_and_pages_are_not(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "en").mkdir(), (folder / "zh").mkdir()
            for language in ("en", "zh"):
                here = folder / language
                tumble("init", "static_bias", "-o", "plan.toml", "--lang", language, folder=here)
                tumble("convert", DATA, "-o", "data.csv", "--lang", language, folder=here)
                tumble("identify", "allan_noise", DATA, "-o", "result.json", "--lang", language, folder=here)
                tumble("report", "result.json", "-o", "report.html", "--language", language, folder=here)
            for file in ("plan.toml", "data.csv", "result.json"):
                self.assertEqual((folder / "en" / file).read_bytes(), (folder / "zh" / file).read_bytes(), file)
            english, chinese = ((folder / language / "report.html").read_text(encoding="utf-8") for language in ("en", "zh"))
            findings = json.loads((folder / "zh" / "result.json").read_text())["findings"]
            self.assertGreater(len(findings), 0)
            listed = re.search(r'<ul class="findings">(.*?)</ul>', chinese, re.DOTALL)[1]
            for item in re.findall(r"<div>([^<]+)", listed):
                self.assertRegex(item, HAN)
            self.assertNotIn("诊断信息", english)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
