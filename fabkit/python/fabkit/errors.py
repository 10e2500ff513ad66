"""Exceptions, with the command's codes and messages; hints name arguments instead of options."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from fabkit import _fabkit

__all__ = ["DesignWarning", "FabkitError", "InvalidInputError", "Problem", "UnknownNameError"]


def __dir__() -> list[str]:
    return __all__


class DesignWarning(UserWarning):
    """A value was set that changes nothing in the design, or the size of the whole."""


@dataclass(frozen=True)
class Problem:
    """One error in an input, with its place and a remedy."""

    message: str
    """The error, with the value and its limit."""
    hint: str | None = None
    """The remedy."""
    file: str | None = None
    """Name of the file that contains it; built-in files end in ``(built-in)``."""
    line: int | None = None
    """Line in the file, from 1."""
    column: int | None = None
    """Column in the line, from 1."""
    path: str | None = None
    """Path of the parameter, for example ``surface.radius``."""
    value: str | None = None
    """The value as it was written."""
    code: str = "bad_input"
    """Kind of problem, a short name that does not change, for example ``out_of_range``."""
    limit: dict[str, Any] | None = None
    """Allowed values: ``min``, ``max`` and their ``unit``, or ``choices``."""
    suggestion: dict[str, Any] | None = None
    """A value that would be accepted: ``path`` and ``value``."""


class FabkitError(Exception):
    """Base class of fabkit's errors.

    ``str(error)`` is what the command prints. The attributes ``hint``, ``file``, ``line``,
    ``column``, ``path`` and ``value`` are those of the first of :attr:`problems`.

    >>> import fabkit
    >>> try:
    ...     fabkit.load("rtac0", coat__thickness="4 mm")
    ... except fabkit.FabkitError as error:
    ...     print(error.code, error.exit_code, error.path, "|", error.value)
    bad-input 2 coat.thickness | 4 mm
    """

    def __init__(
        self,
        text: str,
        *,
        code: str = "bad-input",
        exit_code: int = 2,
        problems: tuple[Problem, ...] = (),
    ) -> None:
        super().__init__(text)
        self.code = code
        """``bad-input``, ``limit``, ``io`` or ``bug``; each problem has a ``code`` of its own."""
        self.exit_code = exit_code
        """Exit code of the command: 2, 3, 4 or 70."""
        self.problems = problems or (Problem(text),)
        """All errors, in order; at least one."""

    def __str__(self) -> str:
        # KeyError, a second base of UnknownNameError, would put the text in quotes.
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        # Executors send exceptions between processes; keyword arguments would be lost.
        state = {"code": self.code, "exit_code": self.exit_code, "problems": self.problems}
        return (type(self), (self.args[0],), state)

    @property
    def hint(self) -> str | None:
        """Remedy."""
        return self.problems[0].hint

    @property
    def file(self) -> str | None:
        """Name of the file that contains the error."""
        return self.problems[0].file

    @property
    def line(self) -> int | None:
        """Line in the file, from 1."""
        return self.problems[0].line

    @property
    def column(self) -> int | None:
        """Column in the line, from 1."""
        return self.problems[0].column

    @property
    def path(self) -> str | None:
        """Path of the parameter, for example ``surface.radius``."""
        return self.problems[0].path

    @property
    def value(self) -> str | None:
        """The value as written."""
        return self.problems[0].value


class InvalidInputError(FabkitError, ValueError):
    """Wrong input: a value out of range, an impossible design, an array of a wrong shape."""


class UnknownNameError(InvalidInputError, KeyError):
    """Unknown name; the hint suggests the closest one."""


def invalid(message: str, hint: str | None = None) -> InvalidInputError:
    """Create an error for an argument that Python code rejects."""
    return InvalidInputError(_with(message, hint), problems=(Problem(message, hint),))


def unknown(what: str, name: object, known: list[str]) -> UnknownNameError:
    """Create an error for an unknown name; its hint suggests the closest known one."""
    hint = _fabkit.hint(str(name), known)
    message = f"there is no {what} `{name}`"
    return UnknownNameError(_with(message, hint), problems=(Problem(message, hint),))


def _with(message: str, hint: str | None) -> str:
    return message if hint is None else f"{message}\n  = help: {hint}"


_EXIT_CODES = {"bad-input": 2, "limit": 3, "io": 4, "bug": 70, "interrupted": 130}


def _of(text: str, code: str, problems: str) -> FabkitError:  # pyright: ignore[reportUnusedFunction]
    """Create an error for the compiled library, which calls this function.

    ``problems`` is JSON text, in the form in which ``--json`` lists problems.
    """
    kind = InvalidInputError if code == "bad-input" else FabkitError
    told: list[dict[str, Any]] = json.loads(problems)
    listed = tuple(
        Problem(
            value=problem["written"],
            **{name: problem[name] for name in Problem.__dataclass_fields__ if name != "value"},
        )
        for problem in told
    )
    return kind(text, code=code, exit_code=_EXIT_CODES[code], problems=listed)
