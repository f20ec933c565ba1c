"""Which recordings, and of which units."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

from tumble._errors import UsageError, wrong_type, wrong_value
from tumble._text import path_text, whole_text
from tumble.archive import ArchivedRecording
from tumble.fleet._store import filesystem_of, is_local
from tumble.fleet._task import ARCHIVE, Task, name_in_archive

GLOB = re.compile(r"[*?\[]")
ACCEPTED = (
    "accepted are a path, a pattern such as 'data/*.h5', a folder, a list of these, a dict from serial to path, and "
    "recordings of an archive"
)


def tasks_of(recordings: Any, serial: str | None) -> list[Task]:
    """The tasks of an argument `recordings`, in order of the names.

    Given     serial  None: the serial number is the file's name without its extension; else a regular expression whose
                      first group, or whole match, finds it in the name
    Raises    UsageError for no recording, a name twice, a pattern that finds nothing, a name without serial number
    """
    if isinstance(recordings, ArchivedRecording):
        recordings = [recordings]
    if isinstance(recordings, (list, tuple)) and any(isinstance(one, ArchivedRecording) for one in recordings):
        tasks = [Task(name_in_archive(one), one.serial) for one in recordings]
    elif isinstance(recordings, Mapping):
        tasks = [Task(path_text(path, "recordings"), str(name)) for name, path in recordings.items()]
    else:
        pattern = _pattern(serial)
        tasks = [Task(name, _serial(name, pattern)) for name in _names(recordings)]
    if not tasks:
        raise UsageError("argument recordings: there is none")
    tasks.sort()
    names = [task.recording for task in tasks]
    twice = sorted({one for one, next_one in pairwise(names) if one == next_one})
    unreadable = [name for name in names if name != name.encode(errors="replace").decode()]
    if unreadable:
        raise UsageError(
            [f"argument recordings: {name!r}: the name is not in UTF-8: rename the file" for name in unreadable]
        )
    if twice:
        raise UsageError([f"argument recordings: {name} is given twice" for name in twice])
    return tasks


def _names(recordings: Any) -> list[str]:
    if isinstance(recordings, (str, os.PathLike)):
        recordings = [recordings]
    if not isinstance(recordings, Iterable) or isinstance(recordings, (bytes, Mapping)):
        raise wrong_type("recordings", recordings, ACCEPTED)
    names: list[str] = []
    for one in recordings:
        if not isinstance(one, (str, os.PathLike)):
            raise wrong_type("recordings", one, ACCEPTED)
        names += _found(path_text(one, "recordings"))
    return names


def _found(text: str) -> list[str]:
    """The files of a pattern or a folder; a plain name stays as it is, whether there is such a file or not."""
    fs, path = filesystem_of(text)
    scheme = text.split("://")[0] + "://" if "://" in text else ""
    local = is_local(fs)
    if GLOB.search(text) and not fs.exists(path):
        found = [str(one) for one in fs.glob(path)]
    elif fs.isdir(path) and not (local and os.path.exists(os.path.join(path, "metadata.yaml"))):
        found = [str(one) for one in fs.find(path) if not os.path.basename(str(one)).startswith(".")]
    else:
        return [text]
    if not found:
        raise UsageError(f"argument recordings: {text} finds no file")
    if local and not os.path.isabs(text) and not scheme:
        found = [os.path.relpath(one) for one in found]
    return [one if local else scheme + one for one in found]


def require_some(tasks: list[Task]) -> None:
    """Raises UsageError where no recording is there: one that is missing among others is a row with its error."""
    for task in tasks:
        if task.recording.startswith(ARCHIVE):
            return
        fs, path = filesystem_of(task.recording)
        if fs.exists(path):
            return
    others = ", nor any other of those that are given" if len(tasks) > 1 else ""
    raise UsageError(f"argument recordings: there is no file {tasks[0].recording}{others}")


def _pattern(serial: str | None) -> re.Pattern[str] | None:
    if serial is None:
        return None
    try:
        return re.compile(whole_text(serial, "serial"))
    except re.error as error:
        raise wrong_value("serial", serial, f"accepted is a regular expression ({error})") from error


def _serial(name: str, pattern: re.Pattern[str] | None) -> str:
    if pattern is None:
        base = os.path.basename(name.rstrip("/"))
        return base.split(".")[0] or base
    found = pattern.search(name)
    if found is None:
        raise UsageError(f"argument serial: {pattern.pattern!r} finds no serial number in {name}")
    return str(found.group(1) if pattern.groups else found.group(0))
