"""Results of ``fabkit check``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

__all__ = ["CheckReport", "Finding"]


def __dir__() -> list[str]:
    return __all__


@dataclass(frozen=True)
class Finding:
    """An error, warning or note that a rule found in a design."""

    rule: str
    """Name of the rule, for example ``interference``."""
    severity: str
    """``error``, ``warning`` or ``note``."""
    message: str
    """The problem, in a sentence."""
    fix: str
    """The remedy."""
    step: str | None = None
    """Name of the affected build step, if any."""
    assembly: str | None = None
    """Name of the affected assembly, if any."""
    bodies: list[str] = field(default_factory=lambda: list[str]())
    """Names of the affected bodies."""
    place_mm: tuple[float, float, float] | None = None
    """Position in the assembly frame, mm."""
    value: float | None = None
    """Measured value, in ``unit``."""
    limit: float | None = None
    """Allowed value, in ``unit``."""
    unit: str | None = None
    """Unit of ``value`` and ``limit``."""


class CheckReport:
    """All findings for a design. True if it has no errors and can be built.

    >>> import fabkit
    >>> report = fabkit.load("tactip").check()
    >>> bool(report), report.errors
    (True, [])
    """

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document
        """Report as ``fabkit check --json`` prints it: ``fabkit-check`` version 1."""
        fields = Finding.__dataclass_fields__
        self.findings = [
            Finding(**{name: finding.get(name) for name in fields})
            for finding in document["findings"]
        ]
        """All findings, in the order of the rules."""

    @property
    def errors(self) -> list[Finding]:
        """Findings that prevent building the design."""
        return [finding for finding in self.findings if finding.severity == "error"]

    def __bool__(self) -> bool:
        return bool(self.document["passed"])

    def __repr__(self) -> str:
        name, count = self.document["name"], len(self.findings)
        return f"<CheckReport of {name}: {count} findings, {len(self.errors)} errors>"
