"""The folder of a fleet: results, rows and logs, on a disk or in an object store (fsspec).

    fleet.json                          which plan, which settings, which version of the program
    results/VERSION/ab/abcd....json     the result of one recording: what `tumble identify -o` writes
    rows/VERSION/ab/abcd....json        its row of the table; written after the result, so that it says: done
    table/model=M/month=YYYY-MM/*.parquet
    log/*.jsonl                         one a run: who did what when, and which recording is which row; in an object
                                        store one of a run follows another, each of some thousand lines

A result and its row are named by the SHA-256 of everything that they depend on, so whoever writes them writes the same.
"""

from __future__ import annotations

import contextlib
import json
import os
import uuid
from collections.abc import Iterator
from typing import Any

from tumble._errors import FileError, UsageError
from tumble._text import need

FORMAT = 1
DOCUMENT = "fleet.json"


class Store:
    """Files below one folder. Each is written whole or not at all."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.fs, self.root = filesystem_of(folder)
        self.is_local = is_local(self.fs)
        if self.is_local:
            self.root = os.path.abspath(self.root)

    def path(self, *parts: str) -> str:
        """The name of a file of the folder, for the file system."""
        return "/".join([self.root.rstrip("/"), *parts])

    def read(self, *parts: str) -> bytes | None:
        """The bytes of a file; None where there is none. Raises FileError."""
        try:
            data: bytes = self.fs.cat_file(self.path(*parts))
        except FileNotFoundError:
            return None
        except OSError as error:
            raise FileError(f"{self.path(*parts)}: {error}") from error
        return data

    def write(self, data: bytes, *parts: str) -> None:
        """Writes a file: beside its name first on a disk; object stores write whole objects. Raises FileError."""
        path = self.path(*parts)
        try:
            if not self.is_local:
                self.fs.pipe_file(path, data)
                return
            os.makedirs(os.path.dirname(path), exist_ok=True)
            unfinished = f"{path}.{uuid.uuid4().hex}.tmp"
            try:
                with open(unfinished, "wb") as file:
                    file.write(data)
                os.replace(unfinished, path)
            except BaseException:
                with contextlib.suppress(OSError):
                    os.remove(unfinished)
                raise
        except OSError as error:
            raise FileError(f"{path}: {error}") from error

    def remove(self, *parts: str) -> None:
        """Removes a file; one that is not there is removed already. Raises FileError."""
        try:
            self.fs.rm_file(self.path(*parts))
        except FileNotFoundError:
            return
        except OSError as error:
            raise FileError(f"{self.path(*parts)}: {error}") from error

    def has(self, *parts: str) -> bool:
        """Whether there is such a file."""
        return bool(self.fs.exists(self.path(*parts)))

    def names(self, *parts: str, suffix: str = "") -> list[str]:
        """Paths of all files below a folder, relative to it, in order."""
        top = self.path(*parts)
        self.fs.invalidate_cache()
        try:
            found = self.fs.find(top)
        except FileNotFoundError:
            return []
        return sorted(one[len(top) + 1 :] for one in map(str, found) if one.endswith(suffix))

    def json(self, *parts: str) -> Any:
        """A JSON file; None where there is none. Raises FileError where it is damaged."""
        data = self.read(*parts)
        if data is None:
            return None
        try:
            return json.loads(data)
        except ValueError as error:
            raise FileError(f"{self.path(*parts)}: {error}") from error

    def folders(self, *parts: str) -> list[str]:
        """Names of the folders in a folder."""
        try:
            found = self.fs.ls(self.path(*parts), detail=True)
        except FileNotFoundError:
            return []
        return sorted(str(one["name"]).rstrip("/").rsplit("/", 1)[-1] for one in found if one["type"] == "directory")

    def lines(self, *parts: str) -> Iterator[dict[str, Any]]:
        """The lines of a log, one after the other. One that a crash cut off is passed over."""
        try:
            with self.fs.open(self.path(*parts), "rb") as file:
                for line in file:
                    with contextlib.suppress(ValueError):
                        yield json.loads(line)
        except FileNotFoundError:
            return
        except OSError as error:
            raise FileError(f"{self.path(*parts)}: {error}") from error


def run_of(name: str) -> str:
    """The run of a log."""
    return name.split(".")[0]


class Log:
    """A log that grows line by line: appended on a disk, written again every few seconds in an object store."""

    PERIOD = 5.0  # [s]
    LINES = 5000  # of one object: more begin the next one

    def __init__(self, store: Store, *parts: str) -> None:
        self._store, self._parts = store, parts
        self._lines: list[str] = []
        self._written, self._full = 0.0, 0
        self._file = None
        if store.is_local:
            path = store.path(*parts)
            try:
                os.makedirs(os.path.dirname(path), exist_ok=True)
                self._file = open(path, "ab", buffering=0)
            except OSError as error:
                raise FileError(f"{path}: {error}") from error

    def add(self, line: dict[str, Any], now: float) -> None:
        """Adds a line. Given: now [s]. Raises FileError."""
        text = json.dumps(line, ensure_ascii=False) + "\n"
        if self._file is not None:
            try:
                self._file.write(text.encode())
            except OSError as error:
                raise FileError(f"{self._store.path(*self._parts)}: {error}") from error
            return
        self._lines.append(text)
        if now - self._written > self.PERIOD or len(self._lines) >= self.LINES:
            self.close()
            self._written = now
        if len(self._lines) >= self.LINES:
            self._lines.clear()
            self._full += 1

    def close(self) -> None:
        """Writes what waits."""
        if self._file is not None:
            self._file.close()
        elif self._lines:
            *folder, name = self._parts
            following = f".{self._full:06}.jsonl" if self._full else ".jsonl"
            self._store.write("".join(self._lines).encode(), *folder, run_of(name) + following)


def filesystem_of(path: str) -> tuple[Any, str]:
    """The file system of a path or an address such as s3://bucket/folder, and the path there. Raises UsageError."""
    core = need("fsspec", "fleet").core
    try:
        fs, root = core.url_to_fs(path)
    except (ImportError, ValueError) as error:
        raise UsageError(f"{path}: {error}") from error
    return fs, str(root)


def is_local(fs: Any) -> bool:
    """Whether this file system is a disk of this machine."""
    protocols = (fs.protocol,) if isinstance(fs.protocol, str) else tuple(fs.protocol)
    return "file" in protocols


def name_of_key(key: str) -> tuple[str, str]:
    """Folder and file of a key."""
    return key[:2], f"{key}.json"
