"""Mappings by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from fabkit.errors import unknown

T = TypeVar("T")


class Named(Mapping[str, T]):
    """Things by name, in order, each made when it is first asked for.

    A name that is not there raises :class:`fabkit.UnknownNameError`, a ``KeyError`` that names the
    closest one.
    """

    def __init__(self, what: str, names: list[str], make: Callable[[str], T]) -> None:
        self._what = what
        self._names = names
        self._make = make
        self._made: dict[str, T] = {}

    def __getitem__(self, name: str) -> T:
        if name not in self._made:
            if name not in self._names:
                raise unknown(self._what, name, self._names)
            self._made[name] = self._make(name)
        return self._made[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __contains__(self, name: object) -> bool:
        # Without making it.
        return name in self._names

    def __repr__(self) -> str:
        return f"<{self._what}s: {', '.join(self._names)}>"
