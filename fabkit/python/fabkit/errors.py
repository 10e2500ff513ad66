"""What fabkit raises: the command's codes and messages; hints name arguments instead of options."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from fabkit import _fabkit

__all__ = ["FabkitError", "InvalidInputError", "Problem", "UnknownNameError"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong."""

    message: str
    """What, with the value and its limit."""
    hint: str | None = None
    """What to do about it."""
    file: str | None = None
    """The file it is in; built-in files have ``(built-in)`` behind their names."""
    line: int | None = None
    """From 1."""
    column: int | None = None
    """From 1."""
    path: str | None = None
    """The parameter, for example ``surface.radius``."""
    value: str | None = None
    """As written."""
    code: str = "bad_input"
    """A short name of the kind of problem, which stays, for example ``out_of_range``."""
    limit: dict[str, Any] | None = None
    """What is allowed: ``min``, ``max`` and their ``unit``, or ``choices``."""
    suggestion: dict[str, Any] | None = None
    """What to write instead: ``path`` and ``value``."""


class FabkitError(Exception):
    """Anything that fabkit cannot do.

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
        """What the command leaves with: 2, 3, 4 or 70."""
        self.problems = problems or (Problem(text),)
        """Everything that is wrong, in order; at least one."""

    def __str__(self) -> str:
        # That of KeyError, a second base of some, is in quotes.
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        # Exceptions travel between processes.
        state = {"code": self.code, "exit_code": self.exit_code, "problems": self.problems}
        return (type(self), (self.args[0],), state)

    @property
    def hint(self) -> str | None:
        """What to do about it."""
        return self.problems[0].hint

    @property
    def file(self) -> str | None:
        """The file it is in."""
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
        """The parameter, for example ``surface.radius``."""
        return self.problems[0].path

    @property
    def value(self) -> str | None:
        """The value as written."""
        return self.problems[0].value


class InvalidInputError(FabkitError, ValueError):
    """Unknown names, values out of range, designs that cannot be, arrays of a wrong shape."""


class UnknownNameError(InvalidInputError, KeyError):
    """A name that is not among those that there are."""


def invalid(message: str, hint: str | None = None) -> InvalidInputError:
    """Make an error found on this side."""
    return InvalidInputError(_with(message, hint), problems=(Problem(message, hint),))


def unknown(what: str, name: object, known: list[str]) -> UnknownNameError:
    """Make an error for a name that is not among those known, with the closest one as a hint."""
    hint = _fabkit.hint(str(name), known)
    message = f"there is no {what} `{name}`"
    return UnknownNameError(_with(message, hint), problems=(Problem(message, hint),))


def _with(message: str, hint: str | None) -> str:
    return message if hint is None else f"{message}\n  = help: {hint}"


_EXIT_CODES = {"bad-input": 2, "limit": 3, "io": 4, "bug": 70, "interrupted": 130}


def _of(text: str, code: str, problems: str) -> FabkitError:  # pyright: ignore[reportUnusedFunction]
    """Make an error of what the native half says: problems as ``--json`` lists them."""
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
