"""What is in the catalogues: methods, models, rigs, formats, checks, plans, units."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from tumble import _tumble


class Entry(Mapping[str, Any]):
    """One entry with all that it says of itself, as `tumble list KIND NAME --json` prints it."""

    __slots__ = ("_document",)

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document = document

    @property
    def name(self) -> str:
        """Name, the word of the command line."""
        return str(self._document["name"])

    @property
    def summary(self) -> str:
        """What it is, in one line."""
        return str(self._document["summary"])

    @property
    def options(self) -> Mapping[str, Mapping[str, Any]]:
        """Options by name, with type, unit, range, default and description."""
        return {one["name"]: one for one in self._document.get("options", ())}

    def __getitem__(self, key: str) -> Any:
        return self._document[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._document)

    def __len__(self) -> int:
        return len(self._document)

    def __repr__(self) -> str:
        return f"<{self.name}: {self.summary}>"


class Catalogue(Mapping[str, Entry]):
    """The entries of one kind, by name. They are read when they are first asked for."""

    __slots__ = ("_entries", "_kind")

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._entries: dict[str, Entry] | None = None

    @property
    def _all(self) -> dict[str, Entry]:
        if self._entries is None:
            self._entries = {one["name"]: Entry(one) for one in json.loads(_tumble.catalogue(self._kind))}
        return self._entries

    def __getitem__(self, name: str) -> Entry:
        if name not in self._all:
            raise KeyError(f"there is no {name!r} among the {self._kind}: {', '.join(self._all)}")
        return self._all[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    def __repr__(self) -> str:
        width = max(len(name) for name in self)
        return "\n".join(f"{entry.name:{width}}  {entry.summary}" for entry in self.values())


methods = Catalogue("methods")
models = Catalogue("models")
rigs = Catalogue("rigs")
formats = Catalogue("formats")
checks = Catalogue("checks")
plans = Catalogue("plans")
units = Catalogue("units")
