"""The archive of units from Python: what `tumble archive` does, docs/archive.md.

from tumble import archive
with archive.open("lab.db") as lab:
    lab.ingest("result.json", "data.h5", by="Li Wei")
    for unit in lab.units():
        print(unit.serial, unit.results)
    lab.history("0173")["results"]
"""

from __future__ import annotations

import builtins
import datetime
import getpass
import json
import os
from collections.abc import Sequence
from types import TracebackType
from typing import Any, NamedTuple

from tumble import _tumble
from tumble._errors import FileError, UsageError, wrong_type, wrong_value
from tumble._result import Result, _from_text
from tumble._text import path_text, whole_text

__all__ = ["Archive", "ArchivedRecording", "ArchivedUnit", "make", "open"]


class ArchivedUnit(NamedTuple):
    """A unit, how many results it has, and when the first and the last were made (UTC)."""

    model: str
    serial: str
    results: int
    first: str
    last: str


class ArchivedRecording(NamedTuple):
    """A recording that the archive keeps, of which unit it is, and where it is kept."""

    model: str
    serial: str
    name: str
    sha256: str
    size: int
    address: str


class Archive:
    """An open archive. Nothing in it is ever changed or deleted."""

    def __init__(self, core: _tumble.Archive) -> None:
        self._core: _tumble.Archive | None = core

    def _opened(self) -> _tumble.Archive:
        if self._core is None:
            raise UsageError("the archive is closed")
        return self._core

    def units(self, model: str = "") -> tuple[ArchivedUnit, ...]:
        """All units in order of model and serial number. Given: model, those of one model; empty: of all."""
        return tuple(ArchivedUnit(**one) for one in json.loads(self._opened().units_json(whole_text(model, "model"))))

    def list(self, model: str = "") -> tuple[ArchivedUnit, ...]:
        """The name that `tumble archive list` has for units()."""
        return self.units(model)

    def recordings(self, model: str = "") -> tuple[ArchivedRecording, ...]:
        """The recordings that the archive keeps, for tumble.fleet.run. Given: model, of its units; empty: of all."""
        core = self._opened()
        found = []
        for unit in self.units(model):
            for file in self.history(f"{unit.model}/{unit.serial}")["files"]:
                if file["role"] == "recording":
                    said = (file["name"], file["sha256"], file["bytes"], core.address)
                    found.append(ArchivedRecording(unit.model, unit.serial, *said))
        return tuple(found)

    def save(self, sha256: str, path: str | os.PathLike[str]) -> None:
        """Writes a file that the archive keeps, with its bytes. Raises FileError where these have changed."""
        self._opened().write_stored(whole_text(sha256, "sha256"), path_text(path, "path"))

    def history(self, unit: str) -> dict[str, Any]:
        """Everything about one unit: results, runs, files, certificates and events, as `history --json` prints it.

        Given     unit  SERIAL, or MODEL/SERIAL
        Raises    UsageError where the archive has no such unit, or several models have the serial number
        """
        document: dict[str, Any] = json.loads(self._opened().history_json(whole_text(unit, "unit")))
        return document

    def result(self, sha256: str) -> Result:
        """A result by the first digits of its SHA-256, six or more. Raises UsageError where it is absent."""
        return _from_text(self._opened().result_text(whole_text(sha256, "sha256")), sha256)

    def population(self, model: str, *, method: str = "", without: str = "") -> Result:
        """The population of a model: what its results say of a unit that was not tested yet; docs/population.md.

        Given     model    of the units, as their results name it
                  method   of the results; empty: the only one that there is
                  without  serial number of a unit that is not to be part of it
        Returned  a result: mean, and as `sd` that of a further unit; a plan can name its file as prior
        Raises    UsageError where no unit has a result, or several methods have; DataError for too few units
        Example   tumble.archive.open("lab.db").population("imu").save("population.json")
        """
        core = self._opened()
        words = (whole_text(model, "model"), whole_text(method, "method"), whole_text(without, "without"))
        return Result(core.population(*words))

    def components(self, model: str, parameter: str, *, method: str = "", without: str = "") -> Result:
        """Why the results of a parameter differ: unit to unit, rig to rig, day to day, turn-on to turn-on.

        Given     model, parameter, method, without  as in population()
        Raises    UsageError, DataError as population()
        """
        core = self._opened()
        words = (whole_text(method, "method"), whole_text(without, "without"))
        return Result(core.components(whole_text(model, "model"), whole_text(parameter, "parameter"), *words))

    def ingest(
        self, *what: Result | str | os.PathLike[str], unit: str | None = None, by: str | None = None
    ) -> dict[str, int]:
        """Puts results and the files that they were made from into the archive. What it has already changes nothing.

        Given     what  Results, and files: results end in .json, the others are recordings and plans
                  unit  MODEL/SERIAL, where results and files do not say it
                  by    who does this; None: the name of the login
        Returned  how many results and files were new, and how many the archive had
        Raises    UsageError with all that is wrong, before anything is written
        """
        texts, files = [], []
        for one in what:
            if isinstance(one, Result):
                texts.append((one.to_json(), "result"))
            elif isinstance(one, (str, os.PathLike)):
                path = path_text(one, "what")
                if path.lower().endswith(".json"):
                    texts.append((_text_of(path), path))
                else:
                    files.append(path)
            else:
                raise wrong_type("what", one, "accepted are Results and paths of files")
        model, slash, serial = ("/" if unit is None else whole_text(unit, "unit")).partition("/")
        if not slash:
            raise wrong_value("unit", unit, "accepted is MODEL/SERIAL")
        who = name_of_user(by)
        results = [(*text, model, serial) for text in texts]
        return dict(self._opened().put(results, files, model, serial, who, _now()))

    def _ingest_results(self, results: Sequence[tuple[str, str, str, str]], by: str) -> dict[str, int]:
        """Puts results in: JSON, name for messages, model, serial number."""
        return dict(self._opened().put(list(results), [], "", "", whole_text(by, "by"), _now()))

    def close(self) -> None:
        """Closes it."""
        self._core = None

    def __enter__(self) -> Archive:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def open(address: str | os.PathLike[str]) -> Archive:  # noqa: A001
    """Opens an archive: a file, or postgresql://USER@HOST/DATABASE.

    Raises    UsageError where there is no archive; FileError where it cannot be opened
    Example   tumble.archive.open("lab.db").units()
    """
    return Archive(_tumble.Archive(path_text(address, "address"), _now()))


def make(address: str | os.PathLike[str], *, files: str = "", by: str | None = None) -> Archive:
    """Makes an empty archive and opens it.

    Given     files  folder of its files; empty: beside the file of the archive
    Raises    UsageError where there is one already
    """
    text = path_text(address, "address")
    _tumble.make_archive(text, whole_text(files, "files"), name_of_user(by), _now())
    return open(text)


def name_of_user(by: str | None) -> str:
    """The one who archives. Raises UsageError where nobody is given and the login has no name, as in a container."""
    if by is not None and whole_text(by, "by"):
        return by
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError) as error:
        raise UsageError("argument by: nothing was given, and this login has no name; accepted is a name") from error


def _now() -> str:
    return datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")


def _text_of(path: str) -> str:

    try:
        with builtins.open(path, encoding="utf-8") as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(f"{path}: {error}") from error
