"""Things by name: the one read-only mapping of the package."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

from tumble._errors import shown

T = TypeVar("T")


class Named(Mapping[str, T]):
    """Things by name, in their order. An unknown name is a KeyError that says which there are."""

    __slots__ = ("_items", "_what")

    def __init__(self, what: str, items: Mapping[str, T]) -> None:
        self._what = what
        self._items: Mapping[str, T] = items

    def __getitem__(self, name: str) -> T:
        try:
            return self._items[name]
        except (KeyError, TypeError, ValueError):
            raise KeyError(f"no {self._what} {shown(name)}; there are {', '.join(self._items) or 'none'}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        return "\n".join(str(item) for item in self._items.values())


class Document(Named[Any]):
    """A part of a JSON document. Lists and objects in it are copies, so that nobody changes the part itself."""

    __slots__ = ()

    def __getitem__(self, name: str) -> Any:
        return copy.deepcopy(super().__getitem__(name))
