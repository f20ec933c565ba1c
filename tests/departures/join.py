"""Joins what the tests of departures wrote, a file a trial, to the matrix for people and to the list of silent cells.

    join.py FOLDER --matrix FILE [--state COMMIT] [--minutes MINUTES]
    join.py FOLDER --silent FILE
    join.py --self-test
"""

import argparse
import collections
import pathlib
import sys
import tempfile

ORDER = ("held", "named", "cannot be seen", "refused", "silent")


def read(folder):
    """Sound tests, cells and impossible cells of all files, in the order of their names."""
    sound, cells, impossible, accused = [], [], [], {}
    for file in sorted(pathlib.Path(folder).glob("*.txt")):
        for line in file.read_text(encoding="utf-8").splitlines():
            kind, *fields = line.split("\t")
            if kind == "accused":
                accused[fields[0]] = fields[1:]
            else:
                {"sound": sound, "cell": cells, "impossible": impossible}[kind].append(fields)
    return [fields + accused.get(fields[0], []) for fields in sound], cells, impossible


def table(heading, rows):
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    return "\n".join(lines + ["| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |" for row in rows]) + "\n"


def matrix(sound, cells, impossible, state, minutes):
    counts = collections.Counter(cell[2] for cell in cells)
    text = "# Departures: `script/departures`\n\n"
    text += f"Commit {state}, {minutes} minutes by the clock. {len(cells)} cells of ten seeds: "
    text += ", ".join(f"{counts[name]} {name}" for name in ORDER) + f"; {len(impossible)} could not be made.\n"
    text += "What the words mean: [docs/departures.md](../../docs/departures.md).\n\n## Sound tests\n\n"
    text += table(("trial", "parameters judged", "tests", "with a warning or error", "refused", "codes",
                   "tests with other seeds", "with a warning or error", "refused", "codes"), sound)
    trials = collections.defaultdict(collections.Counter)
    departures = collections.defaultdict(collections.Counter)
    for name, _, handling, *_ in cells:
        trial, departure = name.split("/")[:2]
        trials[trial][handling] += 1
        departures[departure][handling] += 1
    for title, groups in (("By trial", trials), ("By departure", departures)):
        text += f"\n## {title}\n\n" + table((title.split()[1],) + ORDER, [[key] + [groups[key][name] for name in ORDER] for key in sorted(groups)])
    heading = ("cell", "size", "rms [sd]", "parameter", "named", "refused", "said in its place", "first refusal")
    for handling in ("silent", "refused", "cannot be seen", "named"):  # what holds is only counted
        rows = [[c[0], c[1], *c[3:]] for c in cells if c[2] == handling]
        text += f"\n## {handling.capitalize()}\n\n" + (table(heading, rows) if rows else "No cell.\n")
    if impossible:
        text += "\n## Not made\n\n" + "".join(f"* {line[0]}\n" for line in impossible)
    return text


def write_silent(cells, path):
    """Keeps the comment at the head of the file."""
    path = pathlib.Path(path)
    head = [line for line in path.read_text(encoding="utf-8").splitlines() if line.startswith("#")]
    silent = sorted(cell[0] for cell in cells if cell[2] == "silent")
    path.write_text("\n".join(head + silent) + "\n", encoding="utf-8")


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        pathlib.Path(folder, "a.txt").write_text("sound\ta\t1 of 1\t10\t1\t0\tgap\ncell\ta/clock_fast/x10\t1e+03 ppm\tsilent\t5.10\tK\t0\t0\t\t\n"
                                                 "cell\ta/kelvin\t0 \theld\t1.00\tK\t0\t0\t\t\nimpossible\ta/order_changed: no\n", encoding="utf-8")
        pathlib.Path(folder, "a.sound.txt").write_text("accused\ta\t100\t2\t0\tjumps\n", encoding="utf-8")
        data = read(folder)
        text = matrix(*data, "abc", "1.0")
        assert "2 cells of ten seeds: 1 held, 0 named, 0 cannot be seen, 0 refused, 1 silent; 1 could not be made" in text, text
        assert "| a | 1 of 1 | 10 | 1 | 0 | gap | 100 | 2 | 0 | jumps |" in text, text
        assert "| a/clock_fast/x10 | 1e+03 ppm | 5.10 | K | 0 | 0 |" in text, text
        silent = pathlib.Path(folder, "silent")
        silent.write_text("# head\nold\n", encoding="utf-8")
        write_silent(data[1], silent)
        assert silent.read_text(encoding="utf-8") == "# head\na/clock_fast/x10\n"
    print("the matrix has every cell, and the list the silent ones")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--self-test", action="store_true")
    for name in ("matrix", "silent"):
        parser.add_argument("--" + name)
    for name in ("state", "minutes"):
        parser.add_argument("--" + name, default="?")
    given = parser.parse_args()
    if given.self_test:
        return self_test()
    data = read(given.folder)
    if not data[1]:
        sys.exit(f"{given.folder} has no cell")
    if given.matrix:
        pathlib.Path(given.matrix).write_text(matrix(*data, given.state, given.minutes), encoding="utf-8")
    if given.silent:
        write_silent(data[1], given.silent)
    return None


if __name__ == "__main__":
    main()
