"""Runs every example of the documentation.

    run_docs.py PROGRAM REPOSITORY [--only WORD]
    run_docs.py --self-test

The pages are the .md files at the root of the repository and in docs/ (except docs/decisions and docs/equations). The
examples of one page run in the order of the page, in one bash, in an empty folder with copies of plans/, examples/ and stations/. A
later example sees the files that an earlier one made.

    ```console    lines `$ command` and what they print, compared as in a transcript (run_transcripts.py)
    ```sh         commands, one a line; each must succeed, or end as it says (# exit 1); its output is not compared
    ```toml       a plan; it is written to a file and simulated

A comment before the block says more:

    <!-- file: NAME -->             the plan is written to NAME. It is simulated here only if no later command names it.
    <!-- with: plans/NAME.toml -->  the block is a part of a plan: it is merged into that plan
    <!-- with                       the block is a part of a plan: it is merged into this TOML text
    TOML text
    -->
    <!-- file: NAME with: plans/NAME.toml -->
    <!-- not run: reason -->

Merging goes key by key; a list of the block ([[schedule]], [[recording]]) replaces the list of the plan.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import sys
import time
import tomllib
from dataclasses import dataclass

import run_transcripts

FENCE = re.compile(r"^```(\w*)\s*$")
COMMAND_OR_TABLE = re.compile(r"^(\$ |tumble [a-z]|\[\[?[a-z][\w.]*\]\]?\s*$)")
NOT_PAGES = ("decisions", "equations")


@dataclass
class Block:
    """A fenced block: language, comment before it, lines, and the number of its first line in the page."""

    language: str
    comment: str
    lines: list
    first: int


def faults_of_layout(path, lines):
    """Commands and plans that stand outside of a labelled block, where nobody runs them."""
    faults, language = [], None
    for number, line in enumerate(lines, 1):
        fence = FENCE.match(line)
        if fence:
            language = None if language is not None else fence[1]
            continue
        is_code = language == "" or (language is None and line.startswith("    "))
        if is_code and COMMAND_OR_TABLE.match(line.strip()):
            faults.append(f"{path}:{number}: '{line.strip()}' stands in no ```console, ```sh or ```toml block")
    return faults


def blocks_of(text):
    """All fenced blocks of a page, with the comment that stands directly before each."""
    lines, blocks, comment, i = text.splitlines(), [], "", 0
    while i < len(lines):
        fence = FENCE.match(lines[i])
        if fence:
            end = next((n for n in range(i + 1, len(lines)) if lines[n].startswith("```")), len(lines))
            blocks.append(Block(fence[1], comment, lines[i + 1:end], i + 2))
            comment, i = "", end
        elif lines[i].startswith("<!--"):
            end = next((n for n in range(i, len(lines)) if "-->" in lines[n]), len(lines) - 1)
            comment, i = "\n".join(lines[i:end + 1])[4:].split("-->")[0].strip(), end
        elif lines[i].strip():
            comment = ""
        i += 1
    return blocks


def merged(base, part):
    """The dictionary `base` with the values of `part` on top, table by table."""
    result = dict(base)
    for key, value in part.items():
        both = isinstance(value, dict) and isinstance(base.get(key), dict)
        result[key] = merged(base[key], value) if both else value
    return result


def toml_value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml_key(k)} = {toml_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def toml_key(key):
    return key if re.fullmatch(r"[\w-]+", key) else json.dumps(key)


def toml_text(document):
    """A plan as text: values at the top, then the tables."""
    head, tables = [], []
    for key, value in document.items():
        rows = [value] if isinstance(value, dict) else value
        if isinstance(rows, list) and rows and all(isinstance(row, dict) for row in rows):
            name = f"[{toml_key(key)}]" if isinstance(value, dict) else f"[[{toml_key(key)}]]"
            for row in rows:
                tables += ["", name] + [f"{toml_key(k)} = {toml_value(v)}" for k, v in row.items()]
        elif value != {}:
            head.append(f"{toml_key(key)} = {toml_value(value)}")
    return "\n".join(head + tables) + "\n"


def plan_of(block, source):
    """The text of the plan that a toml block means."""
    text = "\n".join(block.lines) + "\n"
    named = re.search(r"\bwith:\s*(\S+)", block.comment)
    inline = re.match(r"with\n(.*)", block.comment, re.DOTALL)
    if not named and not inline:
        return text
    base = (source / named[1]).read_text(encoding="utf-8") if named else inline[1]
    return toml_text(merged(tomllib.loads(base), tomllib.loads(text)))


def step_of(command, line, expected):
    return run_transcripts.Step(line - 1, 0, 0, command, expected)


def shell_steps(block):
    """The commands of a ```sh block; a backslash at the end of a line joins it with the next."""
    steps, command = [], ""
    for number, line in enumerate(block.lines, block.first):
        command += line
        if command.endswith("\\"):
            command = command[:-1]
            continue
        if command.strip() and not command.startswith("#"):
            steps.append(step_of(command.removeprefix("$ "), number, None))
        command = ""
    return steps


def plan_steps(block, number, source, later):
    """Writes the plan of a ```toml block, and simulates it where no later command uses it."""
    named = re.search(r"\bfile:\s*(\S+)", block.comment)
    name = named[1] if named else f"block-{number}.toml"
    steps = [step_of(f"printf %s {shlex.quote(plan_of(block, source))} > {name}", block.first, None)]
    if not any(name in line for other in later if other.language in ("sh", "console") for line in other.lines):
        steps.append(step_of(f"tumble simulate {name} --seed 1 -o block-{number}.h5", block.first, None))
    return steps


def steps_of(text, source):
    """All commands of a page. Expected output None: the command must succeed, whatever it prints."""
    blocks = [b for b in blocks_of(text) if not b.comment.startswith("not run:")]
    steps = []
    for number, block in enumerate(blocks, 1):
        if block.language == "console":
            for step in run_transcripts.parse("\n".join(block.lines) + "\n"):
                step.first += block.first - 1
                steps.append(step)
        elif block.language == "sh":
            steps += shell_steps(block)
        elif block.language == "toml":
            steps += plan_steps(block, number, source, blocks[number:])
    return steps


def holds(step, actual):
    """Whether a command did what the page says. Three dots never replace a failure."""
    if actual is None:
        return False
    expected = step.expected
    failure = [line for line in actual[-1:] if re.fullmatch(r"\[exit \d+\]|\[the shell ended here\]", line)]
    if expected is None:
        return failure == [f"[{status}]" for status in re.findall(r"# .*\b(exit [1-9])\b", step.command)]
    return run_transcripts.matches(expected, actual) and failure == [line for line in expected[-1:] if line in failure]


def run_page(path, program, source):
    """Number of commands, and one text a failure."""
    text = path.read_text(encoding="utf-8")
    failures = faults_of_layout(path, text.splitlines())
    try:
        steps = steps_of(text, source)
    except (ValueError, OSError) as problem:
        return 1, failures + [f"{path}: {problem}"]
    if not steps:
        return 0, failures
    copy = step_of('cp -r "$TUMBLE_SOURCE"/plans "$TUMBLE_SOURCE"/examples "$TUMBLE_SOURCE"/stations .', 1, None)
    results = run_transcripts.run([copy] + steps, program, source)[1:]
    for step, actual in zip(steps, results):
        if not holds(step, actual):
            shown = "not reached" if actual is None else run_transcripts.difference(step.expected or [], actual)
            failures.append(f"{path}:{step.first + 1}: $ {step.command}\n{shown}")
    return len(steps), failures


def pages(source):
    found = sorted(source.glob("*.md")) + sorted((source / "docs").rglob("*.md"))
    return [p for p in found if not any(part in NOT_PAGES for part in p.relative_to(source).parts)]


PAGE = """# A page

<!-- file: plan.toml -->
```toml
title = "a \\"plan\\""
[rig]
kind = "x"
```

```sh
# a comment
grep -c kind \\
  plan.toml
```

```console
$ cat plan.toml
title = ...
...
$ (exit 3)
[exit 3]
```

<!-- with
title = "base"
[rig]
kind = "y"
sd = "1 m"
[[schedule]]
label = "old"
-->

```toml
[rig]
kind = "z"
[[schedule]]
label = "new"
arm = {rate = "1 deg/s"}
```

<!-- not run: no reason -->
```sh
false
```
"""


def self_test():
    import tempfile
    assert [s.command.split()[0] for s in steps_of(PAGE, None)] == ["printf", "grep", "cat", "(exit", "printf", "tumble"]
    plan = tomllib.loads(plan_of(blocks_of(PAGE)[3], None))
    assert plan == {"title": "base", "rig": {"kind": "z", "sd": "1 m"},
                    "schedule": [{"label": "new", "arm": {"rate": "1 deg/s"}}]}, plan
    for command, expected, actual, is_so in (
            ("c", None, ["x"], True), ("c", None, ["[exit 2]"], False), ("c", None, None, False), ("c", [], ["x"], False),
            ("c  # a limit fails: exit 1", None, ["x", "[exit 1]"], True), ("c  # exit 1", None, ["x"], False),
            ("c", ["a", "..."], ["a", "b"], True), ("c", ["a", "..."], ["a", "[exit 2]"], False),
            ("c", ["[exit 2]"], ["[exit 2]"], True)):
        assert holds(step_of(command, 1, expected), actual) == is_so, (command, expected, actual)
    assert not faults_of_layout("p", PAGE.splitlines())
    for tampered in ("    tumble list\n", "```\ntumble list\n```\n", "    [[recording]]\n", "```\n$ ls\n```\n"):
        assert len(faults_of_layout("p", tampered.splitlines())) == 1, tampered
    with tempfile.TemporaryDirectory() as folder:
        page, root = pathlib.Path(folder, "page.md"), pathlib.Path(folder)
        page.write_text(PAGE)
        assert run_page(page, "/bin/true", root) == (6, []), run_page(page, "/bin/true", root)
        for old, new in (("[exit 3]\n", ""), ("title = ...", "titel = ..."), ("-c kind", "-c absent")):
            page.write_text(PAGE.replace(old, new))
            assert len(run_page(page, "/bin/true", root)[1]) == 1, new
        page.write_text(PAGE)
        assert len(run_page(page, "/bin/false", root)[1]) == 1
    print("self-test passed")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("repository", type=pathlib.Path)
    parser.add_argument("--only", default="", help="run the pages whose name holds this word")
    options = parser.parse_args()
    source = options.repository.resolve()
    chosen = [p for p in pages(source) if options.only in str(p.relative_to(source))]
    if not chosen or not options.program.exists():
        sys.exit(f"nothing to run: {len(chosen)} pages in {source}, program {options.program}")

    def timed(path):
        begin = time.monotonic()
        return path, *run_page(path, options.program.resolve(), source), time.monotonic() - begin

    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for path, count, failures, seconds in pool.map(timed, chosen):
            print("\n".join(failures + [f"{'FAILED' if failures else 'ok    '} {path.relative_to(source)} "
                                        f"({count} commands, {seconds:.1f} s)"]))
            passed, failed = passed + count, failed + len(failures)
    print(f"{passed} commands, {failed} failed")
    sys.exit(1 if failed or not passed else 0)


if __name__ == "__main__":
    main()
