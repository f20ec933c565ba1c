"""Counts tests by label from the results that ctest writes (--output-junit), as a table for people.

    count_tests.py BUILD RESULTS                 what passed, was skipped and failed of each label, and minutes
    count_tests.py BUILD RESULTS --label data    one line for that label
    count_tests.py BUILD RESULTS --slowest 20    the tests that take longest
    count_tests.py --self-test

BUILD is the folder that the tests were built in: it knows their labels. A test of several labels counts under the first of ORDER.
"minutes" adds the tests' own times, and is more than what the clock shows where tests run side by side.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

ORDER = ("unit", "whole", "coverage", "data", "python", "browser", "postgres", "station", "fleet", "departures", "soak")


class Count:
    def __init__(self):
        self.passed = self.skipped = self.failed = 0
        self.seconds = 0.0


def labels_of(build):
    """The label of each test, as ctest knows them."""
    listed = subprocess.run(["ctest", "--test-dir", str(build), "--show-only=json-v1"], check=True, capture_output=True)
    return main_labels(json.loads(listed.stdout))


def main_labels(listed):
    labels = {}
    for test in listed["tests"]:
        given = [v for p in test.get("properties", []) if p["name"] == "LABELS" for v in p["value"]]  # sorted by name
        labels[test["name"]] = ([name for name in ORDER if name in given] + given + ["none"])[0]
    return labels


def cases(path):
    """Name, outcome and seconds of each test. What could not be started has failed."""
    for case in xml.parse(path).getroot().iter("testcase"):
        skipped = case.find("skipped")
        if skipped is not None and "SKIP" in skipped.get("message"):
            outcome = "skipped"
        else:
            outcome = "passed" if case.get("status") == "run" and case.find("failure") is None else "failed"
        yield case.get("name"), outcome, float(case.get("time"))


def count(labels, path):
    """Count by label."""
    counts = {}
    for name, outcome, seconds in cases(path):
        entry = counts.setdefault(labels.get(name, "none"), Count())
        entry.seconds += seconds
        setattr(entry, outcome, getattr(entry, outcome) + 1)
    return counts


def table(counts):
    names = [n for n in ORDER if n in counts] + sorted(n for n in counts if n not in ORDER)
    lines = ["| label | passed | skipped | failed | minutes |", "|---|---:|---:|---:|---:|"]
    for name in names:
        c = counts[name]
        lines.append(f"| {name} | {c.passed} | {c.skipped} | {c.failed} | {c.seconds / 60:.1f} |")
    total = [sum(getattr(c, f) for c in counts.values()) for f in ("passed", "skipped", "failed", "seconds")]
    lines.append(f"| all | {total[0]} | {total[1]} | {total[2]} | {total[3] / 60:.1f} |")
    return "\n".join(lines)


def sentence(counts, label):
    c = counts.get(label, Count())
    return f"{label}: {c.passed + c.failed} tests ran, {c.failed} of them failed; {c.skipped} were skipped"


def slowest(labels, path, number):
    ordered = sorted(cases(path), key=lambda case: -case[2])[:number]
    return "\n".join(f"{seconds:8.1f} s  {labels.get(name, 'none'):<9} {name}" for name, _, seconds in ordered)


def self_test():
    text = """<testsuite>
<testcase name="a" time="30" status="run"/>
<testcase name="b" time="60" status="notrun"><skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/></testcase>
<testcase name="c" time="0" status="fail"><failure message=""/></testcase>
<testcase name="d" time="0" status="run"/>
<testcase name="e" time="0" status="notrun"><skipped message="Unable to find executable"/></testcase>
</testsuite>"""
    listed = {"tests": [{"name": "d"}] + [{"name": name, "properties": [{"name": "LABELS", "value": value}]}
                                          for name, value in (("a", ["unit"]), ("b", ["data"]), ("c", ["fast", "whole"]),
                                                              ("e", ["unit"]))]}
    labels = main_labels(listed)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "tests.xml")
        path.write_text(text)
        counts = count(labels, path)
        longest = slowest(labels, path, 1)
    assert longest.split() == ["60.0", "s", "data", "b"], longest
    lines = table(counts).splitlines()
    assert lines[2:] == ["| unit | 1 | 0 | 1 | 0.5 |", "| whole | 0 | 0 | 1 | 0.0 |", "| data | 0 | 1 | 0 | 1.0 |",
                         "| none | 1 | 0 | 0 | 0.0 |", "| all | 2 | 1 | 2 | 1.5 |"], lines
    assert sentence(counts, "data") == "data: 0 tests ran, 0 of them failed; 1 were skipped"
    assert sentence(counts, "unit").startswith("unit: 2 tests ran, 1 of them failed")
    print("self-test passed")


def main():
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("results", type=pathlib.Path)
    parser.add_argument("--label", help="one line about this label instead of the table")
    parser.add_argument("--slowest", type=int, metavar="N", help="the N tests that take longest instead of the table")
    options = parser.parse_args()
    labels = labels_of(options.build)
    if options.slowest:
        return print(slowest(labels, options.results, options.slowest))
    counts = count(labels, options.results)
    print(sentence(counts, options.label) if options.label else table(counts))
    return None


if __name__ == "__main__":
    main()
