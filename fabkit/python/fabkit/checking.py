"""What ``fabkit check`` finds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["CheckReport", "Finding"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or worth knowing."""

    rule: str
    """For example ``interference``."""
    severity: str
    """``error``, ``warning`` or ``note``."""
    message: str
    """What."""
    fix: str
    """What to do about it."""
    step: str | None = None
    """The step of the chain, if it is about one."""
    assembly: str | None = None
    """The assembly, if it is about one."""
    bodies: list[str] = field(default_factory=lambda: list[str]())
    """The bodies it is about."""
    place_mm: tuple[float, float, float] | None = None
    """Where, assembly frame, mm."""
    value: float | None = None
    """As measured, in ``unit``."""
    limit: float | None = None
    """As allowed, in ``unit``."""
    unit: str | None = None
    """Of value and limit."""


class CheckReport:
    """Everything that the rules found; true if nothing stands in the way of building it.

    >>> import fabkit
    >>> report = fabkit.load("tactip").check()
    >>> bool(report), report.errors
    (True, [])
    """

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document
        """As ``fabkit check --json`` prints it: ``fabkit-check`` version 1."""
        fields = Finding.__dataclass_fields__
        self.findings = [
            Finding(**{name: finding.get(name) for name in fields})
            for finding in document["findings"]
        ]
        """In the order of the rules."""

    @property
    def errors(self) -> list[Finding]:
        """Findings that stand in the way."""
        return [finding for finding in self.findings if finding.severity == "error"]

    def __bool__(self) -> bool:
        return bool(self.document["passed"])

    def __repr__(self) -> str:
        name, count = self.document["name"], len(self.findings)
        return f"<CheckReport of {name}: {count} findings, {len(self.errors)} errors>"
