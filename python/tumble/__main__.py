"""python3 -m tumble: what the program `tumble` leaves to Python.

python3 -m tumble convert FILE -o OUTPUT [--set KEY=VALUE]   also of formats that only Python reads
python3 -m tumble importers                                  these formats
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
from typing import Any

import tumble
from tumble._read import PLAIN, read
from tumble.importers import importers


def main(arguments: list[str] | None = None) -> int:
    """Runs the command and returns its exit status, as the program does."""
    parser = argparse.ArgumentParser(prog="python3 -m tumble", description="What the program tumble leaves to Python")
    verbs = parser.add_subparsers(dest="verb", required=True)
    convert = verbs.add_parser("convert", help="write a recording in another format")
    convert.add_argument("recording", help="recording to read")
    convert.add_argument(
        "-o", "--output", required=True, help="recording to write; the end of its name selects the format"
    )
    convert.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="rate=100, topic=/imu/data, missing=nan, unit.COLUMN=deg/h; repeatable",
    )
    verbs.add_parser("importers", help="list the formats that Python reads")
    given = parser.parse_args(arguments)
    if given.verb == "importers":
        return _print("".join(f"{one.name:10}  {', '.join(one.suffixes):30}  {one.summary}\n" for one in importers()))
    try:
        read(given.recording, **_arguments(given.set)).save(given.output)
    except tumble.TumbleError as error:
        print("error: " + "\n       ".join(error.problems), file=sys.stderr)
        return error.status
    return 0


def _print(text: str) -> int:
    """Exit status: that of a file that cannot be written where nobody takes the text, of a program that a closed pipe
    ended where its reader has enough."""
    try:
        print(text, end="", flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left would fail again at the end
        if isinstance(error, BrokenPipeError):
            return 128 + signal.SIGPIPE
        print(f"error: standard output: {error.strerror}", file=sys.stderr)
        return tumble.FileError.status
    return 0


def _arguments(sets: list[str]) -> dict[str, Any]:
    """The arguments of tumble.read for what --set says."""
    units: dict[str, str] = {}
    made: dict[str, Any] = {"units": units}
    for text in sets:
        key, equals, value = text.partition("=")
        if not key or not equals:
            raise tumble.UsageError(f"--set {text}: write --set key=value")
        if key.startswith("unit."):
            units[key[5:]] = value
        elif key in PLAIN:
            made[key] = value
        elif key == "columns":
            made[key] = value.split(",")
        elif key == "topic":
            made.setdefault("topics", []).append(value)
        else:
            raise tumble.UsageError(f"--set {key}: accepted are {', '.join(PLAIN)}, topic, columns and unit.COLUMN")
    return made


if __name__ == "__main__":
    sys.exit(main())
