"""The check of the workbench: nothing on a page is untranslated, and no room changes the looks of another one.

  languages     [web] of text/en.toml and of text/zh.toml have the same keys and the same placeholders
  translated    every Chinese text has a Han character, or is one of the few that need none
  used          every key that web/src asks for stands in the table, and every key of the table is asked for; a key that
                is made, t(`job_${...}`), stands for all that begin so
  styles        what a selector of a room's stylesheet begins with is a class of that room alone
  circles       no file of web/src imports, directly or through others, a file that imports it
  vendored      every package of third_party/web has the version that web/package.json names

    check_web.py REPOSITORY         exit 1 and one line a fault
    check_web.py --self-test        a sound small tree passes, and every kind of tampering with it is caught
"""

import json
import re
import tomllib

import check_tools

NEED_NO_HAN = {"key_left_right", "key_zero", "key_z", "key_escape", "key_n_p", "key_a_b", "results_caption", "results_note",
                "results_next"}
HAN = re.compile(r"[\u4e00-\u9fff]")
PLACEHOLDER = re.compile(r"\{(\w+)\}")
WORD = re.compile(r"""["'`]([a-z][a-z0-9_]*)["'`]""")
COMMENT, HEAD = re.compile(r"/\*.*?\*/", re.DOTALL), re.compile(r"\w*\.([\w-]+)")
MADE = re.compile(r"t\(`([a-z_]+)\$\{")
IMPORT = re.compile(r"""(?:^(?:import|export)\b[^;"']*|\bimport\(\s*)["'](\.[^"']+)["']""", re.MULTILINE)  # also import("./row")


def texts(root, language):
    return tomllib.loads((root / f"text/{language}.toml").read_text(encoding="utf-8"))["web"]


def faults_of_languages(english, chinese):
    faults = [f"text/zh.toml: [web] lacks {key}" for key in sorted(english.keys() - chinese.keys())]
    faults += [f"text/en.toml: [web] lacks {key}" for key in sorted(chinese.keys() - english.keys())]
    for key in sorted(english.keys() & chinese.keys()):
        if set(PLACEHOLDER.findall(english[key])) != set(PLACEHOLDER.findall(chinese[key])):
            faults.append(f"text/zh.toml: web.{key} has other placeholders than the English text")
        if not HAN.search(chinese[key]) and key not in NEED_NO_HAN:
            faults.append(f"text/zh.toml: web.{key} is not translated: '{chinese[key]}'")
    return faults


def faults_of_use(root, english):
    sources = {path: path.read_text(encoding="utf-8") for path in sorted((root / "web/src").rglob("*.ts*"))}
    words = {word for text in sources.values() for word in WORD.findall(text)}
    made = {prefix for text in sources.values() for prefix in MADE.findall(text)}
    faults = [f"text/en.toml: no page asks for web.{key}" for key in sorted(english)
              if key not in words and not any(key.startswith(prefix) for prefix in made)]
    for path, text in sources.items():
        for key in re.findall(r"""\bt\(["']([a-z0-9_]+)["']""", text):
            if key not in english:
                faults.append(f"{path.relative_to(root)}: asks for web.{key}, which text/en.toml lacks")
    return faults


def first_classes(css):
    selectors = re.findall(r"([^{}@;]+)\{", COMMENT.sub("", css))
    return {found[1] for text in selectors for one in text.split(",") if (found := HEAD.match(one.strip()))}


def faults_of_styles(root):
    rooms, faults = {}, []
    for path in sorted((root / "web/src").glob("*/*.css")):
        for name in sorted(first_classes(path.read_text(encoding="utf-8"))):
            if (other := rooms.setdefault(name, path)).parent != path.parent:
                faults.append(f"{path.relative_to(root)}: .{name} is a class of {other.relative_to(root)} too")
    return faults


def imports_of(path):
    """The files that a file of the pages imports."""
    named = [path.parent / name for name in IMPORT.findall(path.read_text(encoding="utf-8"))]
    found = [one.with_name(one.name + end) for one in named for end in ("", ".ts", ".tsx")]
    return {one.resolve() for one in found if one.is_file()}


def faults_of_circles(root):
    imports = {path.resolve(): imports_of(path) for path in sorted((root / "web/src").rglob("*.ts*"))}
    circles = check_tools.circles(imports)
    return ["web/src: " + ", ".join(path.relative_to((root / "web/src").resolve()).as_posix() for path in circle) + " import each other"
            for circle in circles]


def faults_of_versions(root):
    wanted = json.loads((root / "web/package.json").read_text())["devDependencies"]
    faults = []
    for path in sorted((root / "third_party/web").glob("**/package.json")):
        package = json.loads(path.read_text())
        if wanted.get(package["name"], package["version"]) != package["version"]:
            faults.append(f"{path.relative_to(root)}: version {package['version']}, web/package.json names {wanted[package['name']]}")
    return faults


def check(root):
    english, chinese = texts(root, "en"), texts(root, "zh")
    return faults_of_languages(english, chinese) + faults_of_use(root, english) + faults_of_styles(root) \
        + faults_of_circles(root) + faults_of_versions(root)


SOUND = {
    "text/en.toml": '[web]\nopen = "Open {name}"\njob_done = "done"\n',
    "text/zh.toml": '[web]\nopen = "打开 {name}"\njob_done = "已完成"\n',
    "web/src/a.tsx": 't("open", {name}); t(`job_${state}`)\n',
    "web/src/plans/form.tsx": 'import { Row } from "./row";\n',
    "web/src/plans/row.ts": 'import {\n  t,\n} from "../a";\n',
    "web/src/plans/plans.css": ".bars li, .bars .now { top: 0; }\n@media print { .bars { display: none; } }\n",
    "web/src/station/station.css": "/* .bars */ .axes .now { top: 0; }\n",
    "web/package.json": '{"devDependencies": {"preact": "1.0.0"}}',
    "third_party/web/preact/package.json": '{"name": "preact", "version": "1.0.0"}',
}
TAMPERED = {
    "a key without Chinese": ("text/zh.toml", '[web]\nopen = "打开 {name}"\n', "lacks job_done"),
    "a key without English": ("text/zh.toml", SOUND["text/zh.toml"] + 'more = "更多"\n', "lacks more"),
    "another placeholder": ("text/zh.toml", '[web]\nopen = "打开 {file}"\njob_done = "已完成"\n', "other placeholders"),
    "English among Chinese": ("text/zh.toml", '[web]\nopen = "Open {name}"\njob_done = "已完成"\n', "not translated"),
    "a key that is not there": ("web/src/b.tsx", 't("shut")\n', "asks for web.shut"),
    "a key that nobody asks for": ("web/src/a.tsx", 't("open")\n', "no page asks for web.job_done"),
    "a class of two rooms": ("web/src/station/station.css", "@media print { .bars { top: 0; } }\n", ".bars is a class of"),
    "a circle of two": ("web/src/plans/row.ts", 'import type { Form } from "./form";\n', "plans/form.tsx, plans/row.ts import each other"),
    "a circle that a call closes": ("web/src/plans/row.ts", 'const form = () => import("./form");\n',
                                    "plans/form.tsx, plans/row.ts import each other"),
    "a circle of three": ("web/src/a.tsx", SOUND["web/src/a.tsx"] + 'export { Form } from "./plans/form";\n',
                          "a.tsx, plans/form.tsx, plans/row.ts import each other"),
    "another version": ("third_party/web/preact/package.json", '{"name": "preact", "version": "2.0.0"}', "version 2.0.0"),
}


if __name__ == "__main__":
    check_tools.main(__doc__, lambda root: (check(root), ""), lambda: check_tools.faults_of_tampering(check, SOUND, TAMPERED),
                     "every text of the pages is there in both languages, every room has its own styles, and no files import each other")
