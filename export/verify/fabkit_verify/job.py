"""A verification job: one body, rebuilt in one kernel and compared."""

from __future__ import annotations

import importlib
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import document
from .compare import Check, compare
from .measured import Rebuilt, RebuildError

KERNELS = ("cadquery", "build123d", "manifold3d", "trimesh")


@dataclass(frozen=True)
class Job:
    """Rebuilding and comparison of one body in one kernel. `folder` contains fabkit's export."""

    folder: Path
    part: str
    kernel: str
    # Name of the module with the function `rebuild`.
    module: str

    def run(self) -> dict[str, Any]:
        """Rebuilds and compares. An exception of the kernel becomes the result `failed`."""
        start = time.monotonic()
        try:
            rebuilt, checks = self._compare()
        except (document.DocumentError, RebuildError) as error:
            return self.failed(str(error), time.monotonic() - start)
        except Exception as error:  # pylint: disable=broad-exception-caught
            # OpenCascade's exceptions have no common base class.
            return self.failed(f"{type(error).__name__}: {error}", time.monotonic() - start)
        wrong = [check for check in checks if not check.passed]
        return {
            "part": self.part,
            "kernel": self.kernel,
            "verdict": "differs" if wrong else "agrees",
            "reason": "; ".join(map(_in_words, wrong)),
            "volume": _value(checks, "volume"),
            "distance_mm": _value(checks, "distance"),
            "faces": rebuilt.face_types,
            "checks": [check.as_json() for check in checks],
            "seconds": round(time.monotonic() - start, 2),
        }

    def _compare(self) -> tuple[Rebuilt, list[Check]]:
        tree = document.read(self.folder / f"{self.part}.tree.json")
        samples = document.read_samples(self.folder / f"{self.part}.samples.json")
        if samples["name"] != tree["name"] or samples["design_hash"] != tree.get("design_hash"):
            raise document.DocumentError(self.part, ["tree and samples are of different designs"])
        rebuilt = importlib.import_module(self.module).rebuild(tree, samples, self.folder)
        return rebuilt, compare(tree, samples, rebuilt)

    def failed(self, reason: str, seconds: float) -> dict[str, Any]:
        """Returns the result of a job that could not be finished."""
        return {
            "part": self.part,
            "kernel": self.kernel,
            "verdict": "failed",
            "reason": reason,
            "volume": None,
            "distance_mm": None,
            "faces": {},
            "checks": [],
            "seconds": round(seconds, 2),
        }


def jobs(folder: Path, parts: list[str], kernels: list[str]) -> list[Job]:
    """Creates a job for each part in each kernel."""
    return [
        Job(folder, part, kernel, f"fabkit_verify.kernels.with_{kernel}")
        for part in parts
        for kernel in kernels
    ]


def _value(checks: list[Check], what: str) -> float | None:
    return next((check.as_json()["value"] for check in checks if check.what == what), None)


def _in_words(check: Check) -> str:
    if check.what in ("complaints", "genus", "shells", "containment", "landmarks"):
        return check.note if check.what != "landmarks" else f"landmarks: {check.note}"
    note = f" {check.note}" if check.note else ""
    unit = f" {check.unit}" if check.unit else ""
    return f"{check.what} {check.value:.3g}{unit}, limit {check.limit:.3g}{note}"
