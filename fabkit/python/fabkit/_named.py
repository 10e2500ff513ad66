"""A lazy mapping from names to objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

from fabkit.errors import unknown

T = TypeVar("T")


class Named(Mapping[str, T]):
    """Objects by name, in a fixed order, each created at its first access.

    An unknown name raises :class:`fabkit.UnknownNameError`, a ``KeyError`` that suggests the
    closest name.
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
        # The default implementation would create the object.
        return name in self._names

    def __repr__(self) -> str:
        return f"<{self._what}s: {', '.join(self._names)}>"
