"""Networks that experiments train: an ONNX file each, with a card in JSON."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from fabkit_bench._onnx import OnnxNetwork

__all__ = ["FORMAT", "Card", "HeldOut", "Network", "Numbers", "digest", "files", "remove_stale"]

FORMAT = "fabkit-bench-network"
FOLDER = "networks"

_RAW = "none: what it was standardised by while it learned is part of the network"


@dataclass(frozen=True)
class Network:
    """A network that an experiment trained."""

    onnx: bytes
    """Content of the ONNX file."""
    card: dict[str, Any]
    """Description: input, output, training, and errors on held-out samples."""


@dataclass(frozen=True)
class Numbers:
    """Description of a network's input or output."""

    what: str
    """Meaning, in words."""
    units: Mapping[str, str] | str
    """Unit of each number by its name, or of all numbers."""
    more: dict[str, Any] = field(default_factory=dict[str, Any])
    """Further facts: frame, names and positions of markers."""

    def document(self) -> dict[str, Any]:
        """Return the card's entry."""
        if isinstance(self.units, str):
            return {"what": self.what, "unit": self.units, **self.more}
        named = [{"name": name, "unit": unit} for name, unit in self.units.items()]
        return {"what": self.what, "numbers": named, **self.more}


@dataclass(frozen=True)
class HeldOut:
    """Error of a network on held-out samples."""

    what: str
    """Kind of error and of samples, in words."""
    value: float | None
    """Error, in ``unit``; ``None`` without samples."""
    unit: str
    samples: int
    """Number of held-out samples."""

    def __post_init__(self) -> None:
        if self.value is not None and not np.isfinite(self.value):
            # JSON has no NaN or infinity.
            object.__setattr__(self, "value", None)


@dataclass(frozen=True)
class Card:
    """The part of a network's card that its experiment knows."""

    takes: Numbers
    """Input."""
    gives: Numbers
    """Output."""
    mask: str | dict[str, Any]
    """Pixels or markers that it takes, and those for which its output holds."""
    training: tuple[int, str]
    """Number of training samples, and their kind in words."""
    held_out: list[HeldOut]
    """Errors on held-out samples."""

    def document(self, written: OnnxNetwork) -> dict[str, Any]:
        """Return the whole card for an ONNX file."""
        return {
            "form": written.form,
            "takes": {
                "name": "x",
                "type": written.type,
                "shape": list(written.takes),
                "normalisation": _RAW,
                **self.takes.document(),
            },
            "mask": self.mask,
            "gives": {
                "name": "y",
                "type": written.type,
                "shape": list(written.gives),
                **self.gives.document(),
            },
            "training": {
                "samples": self.training[0],
                "of": self.training[1],
                "how": written.learned,
            },
            "held_out": [asdict(one) for one in self.held_out],
            "sha256": digest(written.onnx),
        }


def digest(onnx: bytes) -> str:
    """Compute the SHA-256 by which a card names its ONNX file."""
    return hashlib.sha256(onnx).hexdigest()


def files(networks: Mapping[str, Network]) -> dict[str, bytes]:
    """Return the content of all files by path, relative to the folder of ``bench.json``."""
    found: dict[str, bytes] = {}
    for name, network in networks.items():
        found[f"{FOLDER}/{name}.onnx"] = network.onnx
        card = json.dumps(network.card, indent=2, ensure_ascii=False) + "\n"
        found[f"{FOLDER}/{name}.json"] = card.encode()
    return found


def remove_stale(folder: Path, networks: Mapping[str, Network]) -> None:
    """Remove networks and cards of an earlier run, which could be mistaken for this one's.

    Files that fabkit did not write, or that were changed since, stay.
    """
    for path in sorted((folder / FOLDER).glob("*.json")):
        if path.stem in networks or (card := _own(path)) is None:
            continue
        onnx = path.with_suffix(".onnx")
        if onnx.is_file() and digest(onnx.read_bytes()) == card.get("sha256"):
            onnx.unlink()
        path.unlink()


def _own(path: Path) -> dict[str, Any] | None:
    """Read a card; return ``None`` if the file is not a card of this package."""
    try:
        card: dict[str, Any] = json.loads(path.read_bytes())
        return card if card["format"] == FORMAT else None
    except (ValueError, TypeError, KeyError):
        return None
