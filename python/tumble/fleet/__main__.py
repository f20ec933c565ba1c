"""python3 -m tumble.fleet: what the verb `tumble fleet` leaves to Python.

python3 -m tumble.fleet run PLAN RECORDING... -o FOLDER    reduce many recordings
python3 -m tumble.fleet record PLAN FILE... -o FOLDER      the noise of one record in many files
python3 -m tumble.fleet status FOLDER                      what is done
python3 -m tumble.fleet compact FOLDER                     fewer files, after many runs
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from typing import Any

import tumble
from tumble import fleet


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command and returns its exit status, as the program does."""
    parser = argparse.ArgumentParser(
        prog="tumble fleet", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    for name, what in (
        ("run", "reduce many recordings by one plan"),
        ("record", "the noise of one record in many files"),
    ):
        verb = verbs.add_parser(name, help=what, description=what)
        verb.add_argument("plan", help="plan file, or the name of a method that needs none")
        verb.add_argument("recordings", nargs="+", help="recordings, patterns, folders; also s3://")
        verb.add_argument("-o", "--output", required=True, help="folder of the fleet")
        verb.add_argument("--executor", default="processes", help="processes (default), serial or dask")
        verb.add_argument("--scheduler", help="address of a Dask scheduler: tcp://host:8786")
        verb.add_argument("--workers", type=int, help="number of processes (default: one for each processor)")
        verb.add_argument("--retries", type=int, default=2, help="how often a task is tried again (default: 2)")
        verb.add_argument(
            "--patience", type=float, default=600.0, help="seconds to wait while a cluster has no worker (default: 600)"
        )
        verb.add_argument(
            "--set", action="append", default=[], metavar="KEY=VALUE", help="replaces a value of the plan"
        )
    run = verbs.choices["run"]
    run.add_argument(
        "--serial", help="regular expression that finds the serial number in a name (default: the file's name)"
    )
    run.add_argument("--timeout", type=float, help="seconds after which a worker is ended")
    run.add_argument("--retry-errors", action="store_true", help="reduce recordings again whose row is an error")
    run.add_argument("--archive", help="archive that takes the results")
    run.add_argument("--by", help="who archives them")
    for name, what in (("status", "what is done"), ("compact", "make one file of each folder of the table")):
        verb = verbs.add_parser(name, help=what, description=what)
        verb.add_argument("folder", help="folder of a fleet")
    given = parser.parse_args(arguments)
    try:
        return {"run": _run, "record": _record, "status": _status, "compact": _compact}[given.verb](given)
    except tumble.TumbleError as error:
        print("\r\033[K" if sys.stderr.isatty() else "", end="", file=sys.stderr)
        print("error: " + "\n       ".join(error.problems), file=sys.stderr)
        return error.status
    except KeyboardInterrupt:
        print("\ninterrupted; the same command goes on where it ended", file=sys.stderr)
        return 130


class _Line:
    """Progress in one line of the terminal, with the time that remains."""

    def __init__(self) -> None:
        self._first: tuple[float, float] | None = None

    def __call__(self, done: float, what: str) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = (now, done)
        begun, before = self._first
        left = (now - begun) * (1.0 - done) / (done - before) if done > before else 0.0
        text = f"{what}" + (f", {left:.0f} s left" if left > 0.0 else "")
        if sys.stderr.isatty():
            print(f"\r\033[K{text}", end="\n" if done >= 1.0 else "", file=sys.stderr, flush=True)


def _common(given: argparse.Namespace) -> dict[str, Any]:
    settings: dict[str, object] = {}
    for text in given.set:
        key, equals, value = text.partition("=")
        if not key or not equals:
            raise tumble.UsageError(f"--set {text}: write --set key=value")
        settings[key] = value
    executor: Any = given.executor
    if given.scheduler is not None:
        from tumble._text import need

        try:
            executor = need("distributed", "fleet").Client(given.scheduler, timeout=10)
        except OSError as error:
            raise tumble.UsageError(f"--scheduler {given.scheduler}: {error}") from error
    return {
        "executor": executor,
        "workers": given.workers,
        "settings": settings or None,
        "retries": given.retries,
        "patience": given.patience,
        "progress": _Line(),
    }


def _run(given: argparse.Namespace) -> int:
    many = given.recordings if len(given.recordings) > 1 else given.recordings[0]
    made = fleet.run(
        given.plan,
        many,
        given.output,
        serial=given.serial,
        timeout=given.timeout,
        retry_errors=given.retry_errors,
        archive=given.archive,
        by=given.by,
        **_common(given),
    )
    print(made.status())
    for recording, error in sorted(made.errors().items())[:20]:
        print(f"  {recording}: {error}")
    return 3 if made.errors() else 0


def _record(given: argparse.Namespace) -> int:
    print(fleet.record(given.plan, given.recordings, given.output, **_common(given)), end="")
    return 0


def _compact(given: argparse.Namespace) -> int:
    parts, rows = fleet.Fleet(given.folder).compact()
    print(f"{parts} files of the table and {rows} files of rows became part of others")
    return 0


def _status(given: argparse.Namespace) -> int:
    print(fleet.Fleet(given.folder).status())
    return 0


if __name__ == "__main__":
    sys.exit(main())
