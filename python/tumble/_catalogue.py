"""What is in the catalogues: methods, models, rigs, formats, checks, exports, plans, units."""

from __future__ import annotations

import json
from collections import UserDict
from collections.abc import Mapping
from functools import cached_property
from typing import Any

from tumble import _tumble
from tumble._named import Document, Named


class Entry(Document):
    """One entry with all that it says of itself, as `tumble list KIND NAME --json` prints it."""

    __slots__ = ()

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__("key", document)

    @property
    def name(self) -> str:
        """Name, the word of the command line."""
        return str(self["name"])

    @property
    def summary(self) -> str:
        """What it is, in one line."""
        return str(self["summary"])

    @property
    def options(self) -> Mapping[str, Mapping[str, Any]]:
        """Options by name, with type, unit, range, default and description."""
        return {one["name"]: one for one in self.get("options", ())}

    def __repr__(self) -> str:
        return f"<{self.name}: {self.summary}>"


class Catalogue(Named[Entry]):
    """The entries of one kind, by name. They are read when they are first asked for."""

    __slots__ = ()

    def __init__(self, kind: str) -> None:
        super().__init__(kind.removesuffix("s"), _Entries(kind))

    def __repr__(self) -> str:
        width = max(len(name) for name in self)
        return "\n".join(f"{entry.name:{width}}  {entry.summary}" for entry in self.values())


class _Entries(UserDict[str, Entry]):
    """The entries of a kind, read when they are first looked at."""

    def __init__(self, kind: str) -> None:
        self._kind = kind

    @cached_property
    def data(self) -> dict[str, Entry]:  # type: ignore[override]
        return {one["name"]: Entry(one) for one in json.loads(_tumble.catalogue(self._kind))}


methods = Catalogue("methods")
models = Catalogue("models")
rigs = Catalogue("rigs")
formats = Catalogue("formats")
checks = Catalogue("checks")
exports = Catalogue("exports")
plans = Catalogue("plans")
units = Catalogue("units")
