"""Parameters of a design, and conversion of values to the text of a sensor file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from fabkit.errors import invalid, unknown

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["Parameter", "Section"]


def __dir__() -> list[str]:
    return __all__


def overrides_of(
    overrides: Mapping[str, object] | None, values: dict[str, object]
) -> dict[str, object]:
    """Merge overrides with keyword arguments (``__`` for a dot) into values by path."""
    named = {name.replace("__", "."): value for name, value in values.items()}
    both = sorted(named.keys() & (overrides or {}).keys())
    if both:
        raise invalid(f"{both[0]} is given twice: in overrides and by keyword")
    return {**(overrides or {}), **named}


def as_yaml(path: str, value: object) -> str:
    """Write a value as YAML, as the command line takes it; ``path`` is for messages."""
    if isinstance(value, Parameter):
        return value.written
    if isinstance(value, np.generic):
        value = cast("object", value.item())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str | int | float):
        return str(value)
    if isinstance(value, list | tuple | np.ndarray):
        items: list[object] = list(value)  # pyright: ignore[reportUnknownArgumentType]
        return f"[{', '.join(as_yaml(path, item) for item in items)}]"
    raise invalid(
        f"{path} is a {type(value).__name__}; it must be text, a number or a list of these"
    )


@dataclass(frozen=True)
class Parameter:
    """A number or a choice that determines a design, with its limits and source.

    >>> import fabkit
    >>> radius = fabkit.load("rtac0").parameters["surface.radius"]
    >>> radius.value, radius.unit, str(radius), radius.limit["max"]
    (15.0, 'mm', '15 mm', 60.0)
    """

    path: str
    """Path, for example ``surface.radius``."""
    value: Any
    """Value: a number in ``unit``, ``True`` or ``False``, text, or a list of these."""
    unit: str | None
    """Unit: ``mm``, ``deg``, or ``None`` for a value without one."""
    written: str
    """Value with its unit, as in a sensor file."""
    limit: dict[str, Any] | None
    """Allowed values: ``min`` and ``max`` in ``unit``, or ``choices``; for a list, of each item."""
    limits: str
    """Allowed values as text."""
    summary: str
    """Description of the parameter."""
    source: str
    """Source of the value: ``paper``, ``measured``, ``chosen`` or ``override``."""
    note: str
    """Details about the source."""
    tolerance: str | None = None
    """Tolerance of the manufactured dimension, plus or minus, if the file states one."""
    expression: str | None = None
    """Expression that gives the value, ``= surface.radius - 3 mm``; ``None`` for a plain value."""

    def __str__(self) -> str:
        return self.written


class Section:
    """Values of parameters by attribute: numbers in the unit that ``parameters`` gives.

    >>> import fabkit
    >>> sensor = fabkit.load("rtac0")
    >>> sensor.surface.radius, sensor.values.camera.field_of_view
    (15.0, 160.0)
    """

    def __init__(self, parameters: Mapping[str, Parameter], path: str = "") -> None:
        self._parameters = parameters
        self._path = path

    def _keys(self) -> list[str]:
        keys = (p[len(self._path) :].split(".")[0] for p in self._parameters if self._has(p))
        return list(dict.fromkeys(keys))

    def _has(self, path: str) -> bool:
        return path.startswith(self._path)

    def __getattr__(self, name: str) -> Any:
        # `copy` and `pickle` look up dunders before `_parameters` exists: no endless recursion.
        if name.startswith("_"):
            raise AttributeError(name)
        path = self._path + name
        if path in self._parameters:
            return self._parameters[path].value
        if name in self._keys():
            return Section(self._parameters, f"{path}.")
        raise AttributeError(unknown("parameter", path, list(self._parameters)).args[0])

    def __dir__(self) -> list[str]:
        return self._keys()

    def __repr__(self) -> str:
        shown = (
            f"{p[len(self._path) :]}: {v}" for p, v in self._parameters.items() if self._has(p)
        )
        return f"<{', '.join(shown)}>"
