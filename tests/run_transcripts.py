"""Runs the transcripts of a folder and compares what each command prints with what the file says.

    run_transcripts.py PROGRAM FOLDER [--update] [--only WORD]
    run_transcripts.py --self-test

A transcript (FOLDER/*.txt) reads like a terminal:

    # Prose: lines that start with # after a blank line or at the top.
    $ tumble inspect data.csv
    expected output, standard output and standard error together
    ...                                a line of three dots stands for any number of lines
    rate 100 Hz, ... samples           three dots in a line stand for any text
    [exit 3]                           last line, where the status is not 0

    $ cat > plan.toml <<END
    > title = "a here-document"        a command goes on over lines that start with "> "
    > END

Each file runs in one bash of its own, in a temporary folder of its own, so later commands see the files and variables
of earlier ones. PROGRAM is called `tumble`; TUMBLE_SOURCE is the repository. Trailing blank lines do not count.
--update rewrites the expected output of every command that does not match.
"""

import argparse
import difflib
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
from dataclasses import dataclass

SECONDS_PER_FILE = 300
MARKER = "@@ end of command, status"


@dataclass
class Step:
    """One command of a transcript. Lines first (of the command), begin and end (of what is expected) count from 0."""

    first: int
    begin: int
    end: int
    command: str
    expected: list


def is_prose(lines, i):
    """A # line after a blank line, at the top, or after prose."""
    while i >= 0 and lines[i].startswith("#"):
        i -= 1
    return i < 0 or lines[i] == ""


def without_trailing_blanks(lines):
    while lines and lines[-1] == "":
        lines = lines[:-1]
    return lines


def parse(text):
    lines = text.splitlines()
    steps = []
    i = 0
    while i < len(lines):
        if not lines[i].startswith("$ "):
            if lines[i] and not lines[i].startswith("#"):
                raise ValueError(f"line {i + 1} belongs to no command: {lines[i]}")
            i += 1
            continue
        first, command = i, [lines[i][2:]]
        i += 1
        while i < len(lines) and (lines[i].startswith("> ") or lines[i] == ">"):
            command.append(lines[i][2:])
            i += 1
        begin = i
        while i < len(lines) and not lines[i].startswith("$ ") and not (lines[i].startswith("#") and is_prose(lines, i)):
            i += 1
        expected = without_trailing_blanks(lines[begin:i])
        steps.append(Step(first, begin, begin + len(expected), "\n".join(command), expected))
    return steps


def run(steps, program, source):
    """What each step printed, as lines with the closing [exit N]; None for steps that were not reached."""
    script = ["exec 2>&1"]
    for step in steps:
        script += [f"eval {shlex.quote(step.command)}", f"printf '\\n%s %d\\n' {shlex.quote(MARKER)} $?"]
    with tempfile.TemporaryDirectory(prefix="transcript-") as folder:
        home, bin_folder = pathlib.Path(folder, "work"), pathlib.Path(folder, "bin")
        home.mkdir()
        bin_folder.mkdir()
        (bin_folder / "tumble").symlink_to(program)
        kept = {k: v for k, v in os.environ.items() if k.endswith("SAN_OPTIONS")}
        environment = {**kept, "PATH": f"{bin_folder}:/usr/bin:/bin", "HOME": str(home), "LC_ALL": "C.UTF-8",
                       "NO_COLOR": "1", "TERM": "dumb", "TUMBLE_SOURCE": str(source)}
        script_file = pathlib.Path(folder, "script")
        script_file.write_text("\n".join(script) + "\n")
        try:
            output = subprocess.run(["bash", "--norc", str(script_file)], cwd=home, env=environment,
                                    stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, timeout=SECONDS_PER_FILE).stdout
        except subprocess.TimeoutExpired as late:
            output = (late.stdout or b"") + f"\nstopped after {SECONDS_PER_FILE} s\n".encode()
    parts = re.split(rf"\n{MARKER} (\d+)\n", output.decode("utf-8", "replace"))
    outputs, statuses = parts[0::2], parts[1::2]
    results = []
    for i in range(len(steps)):
        if i < len(statuses):
            lines = without_trailing_blanks(outputs[i].splitlines())
            results.append(lines + ([f"[exit {statuses[i]}]"] if statuses[i] != "0" else []))
        elif i == len(statuses):
            results.append(outputs[i].splitlines() + ["[the shell ended here]"])
        else:
            results.append(None)
    return results


def line_pattern(line):
    return re.compile(".*".join(re.escape(part) for part in line.split("...")))


def matches(expected, actual):
    """`...` lines match any number of lines. Reaches row by row which prefixes of `actual` the pattern can have eaten."""
    reached = {0}
    for line in expected:
        if line == "...":
            reached = set(range(min(reached), len(actual) + 1)) if reached else set()
        else:
            pattern = line_pattern(line)
            reached = {n + 1 for n in reached if n < len(actual) and pattern.fullmatch(actual[n])}
    return len(actual) in reached


def difference(expected, actual):
    """A diff for people: an expected line with dots that matches some actual line counts as that line."""
    shown = []
    for line in expected:
        pattern = line_pattern(line) if "..." in line and line != "..." else None
        shown.append(next((a for a in actual if pattern and pattern.fullmatch(a)), line))
    return "\n".join(list(difflib.unified_diff(shown, actual, "expected", "printed", lineterm="", n=3)))


def writable(actual):
    """Output as it may stand in a transcript: what would be read as a command or as prose becomes three dots."""
    lines = []
    for i, line in enumerate(actual):
        taken = line.startswith("$ ") or (i == 0 and line.startswith(">")) or (line.startswith("#") and is_prose(["$"] + actual, i + 1))
        if not taken:
            lines.append(line)
        elif not lines or lines[-1] != "...":
            lines.append("...")
    return lines


def rewritten(text, steps, results):
    lines = text.splitlines()
    for step, actual in reversed(list(zip(steps, results))):
        if actual is not None and not matches(step.expected, actual):
            spacing = [""] if step.end == step.begin and step.end < len(lines) and lines[step.end] != "" else []
            lines[step.begin:step.end] = writable(actual) + spacing
    return "\n".join(lines) + "\n"


def run_file(path, program, source, update):
    """Counts of passed and failed commands; prints the failures."""
    text = path.read_text(encoding="utf-8")
    steps = parse(text)
    if not steps:
        raise ValueError("no command in it")
    results = run(steps, program, source)
    failed = 0
    for step, actual in zip(steps, results):
        if actual is not None and matches(step.expected, actual):
            continue
        failed += 1
        if not update:
            print(f"{path}:{step.first + 1}: $ {step.command}")
            print("not reached" if actual is None else difference(step.expected, actual))
    if update and failed:
        path.write_text(rewritten(text, steps, results), encoding="utf-8")
        print(f"{path}: {failed} rewritten")
        failed = 0
    print(f"{'FAILED' if failed else 'ok    '} {path.name} ({len(steps)} commands)")
    return len(steps) - failed, failed


def self_test():
    text = """# prose
# more prose
$ echo one; echo two >&2
one
two

# between
$ value=3; cat > file <<END
> a $value

> END
$ cat file; printf 'no newline'
"""
    text = text.replace("> a $value\n\n", "> # at the top\n> a $value\n>\n> # not prose\n") + """# at the top
a 3
...
no newline
$ (exit 4)
[exit 4]
$ seq 9; cd /; pwd
1
...
8
n...e
"""
    steps = parse(text)
    assert [s.command.split()[0] for s in steps] == ["echo", "value=3;", "cat", "(exit", "seq"], steps
    results = run(steps, "/bin/true", "/")
    assert results[0] == ["one", "two"] and results[1] == [] and results[3] == ["[exit 4]"], results
    assert results[2] == ["# at the top", "a 3", "", "# not prose", "no newline"], results
    assert matches(steps[2].expected, results[2]) and writable(results[2]) == ["# at the top", "a 3", "", "...", "no newline"]
    assert results[4][-1] == "/" and not matches(steps[4].expected, results[4])
    assert matches(["..."], []) and matches(["a", "...", "z"], ["a", "z"]) and matches(["a...c"], ["abc"])
    assert not matches([], ["x"]) and not matches(["x"], []) and not matches(["a.c"], ["abc"])
    assert not matches(["..."] + ["z"], ["a"]) and not matches(["a"], ["a", "[exit 1]"])
    assert run(parse("$ exit 3\n$ echo lost\n"), "/bin/true", "/")[1] is None
    assert run(parse("$ if\n$ echo next\n"), "/bin/true", "/")[1] == ["next"]
    updated = rewritten(text, steps, results)
    again = parse(updated)
    assert all(matches(s.expected, r) for s, r in zip(again, results)) and "# between" in updated, updated
    print("self-test passed")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path, help="or one transcript of it")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--only", default="", help="run the files whose name holds this word")
    options = parser.parse_args()
    source = pathlib.Path(__file__).resolve().parent.parent
    folder = options.folder
    files = [folder] if folder.is_file() else [f for f in sorted(folder.glob("*.txt")) if options.only in f.name]
    if not files or not options.program.exists():
        sys.exit(f"nothing to run: {len(files)} transcripts in {options.folder}, program {options.program}")
    passed = failed = 0
    for path in files:
        try:
            good, bad = run_file(path, options.program.resolve(), source, options.update)
        except ValueError as problem:
            print(f"FAILED {path}: {problem}")
            good, bad = 0, 1
        passed, failed = passed + good, failed + bad
    print(f"{passed} passed, {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
