"""Networks that experiments have trained: each an ONNX file with a card beside it."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from fabkit_bench._onnx import Written

__all__ = ["FORMAT", "Card", "HeldOut", "Network", "Numbers", "digest", "files", "remove_stale"]

FORMAT = "fabkit-bench-network"
FOLDER = "networks"

_RAW = "none: what it was standardised by while it learned is part of the network"


@dataclass(frozen=True)
class Network:
    """A network that an experiment has trained."""

    onnx: bytes
    """The file."""
    card: dict[str, Any]
    """What it takes and gives, how it was trained, how far off it is on what was held out."""


@dataclass(frozen=True)
class Numbers:
    """What goes into a network, or comes out."""

    what: str
    """In words."""
    units: Mapping[str, str] | str
    """Of each number by its name, or of all of them."""
    more: dict[str, Any] = field(default_factory=dict[str, Any])
    """What else is to be known: frame, names of marks, where they are."""

    def document(self) -> dict[str, Any]:
        """Make what the card says."""
        if isinstance(self.units, str):
            return {"what": self.what, "unit": self.units, **self.more}
        named = [{"name": name, "unit": unit} for name, unit in self.units.items()]
        return {"what": self.what, "numbers": named, **self.more}


@dataclass(frozen=True)
class HeldOut:
    """How far a network is off on what it has not seen."""

    what: str
    """Which error, and of what."""
    value: float | None
    """None where there is nothing to take the mean of."""
    unit: str
    samples: int

    def __post_init__(self) -> None:
        if self.value is not None and not np.isfinite(self.value):
            # JSON has no word for it.
            object.__setattr__(self, "value", None)


@dataclass(frozen=True)
class Card:
    """What the experiment alone knows of a network."""

    takes: Numbers
    gives: Numbers
    mask: str | dict[str, Any]
    """Which pixels or marks it sees, and where it answers."""
    training: tuple[int, str]
    """How many samples, and what they are."""
    held_out: list[HeldOut]

    def document(self, written: Written) -> dict[str, Any]:
        """Make what the card says of such a file."""
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
    """Tell which file a card belongs to."""
    return hashlib.sha256(onnx).hexdigest()


def files(networks: Mapping[str, Network]) -> dict[str, bytes]:
    """List what is written, by its place in the folder of ``bench.json``."""
    found: dict[str, bytes] = {}
    for name, network in networks.items():
        found[f"{FOLDER}/{name}.onnx"] = network.onnx
        card = json.dumps(network.card, indent=2, ensure_ascii=False) + "\n"
        found[f"{FOLDER}/{name}.json"] = card.encode()
    return found


def remove_stale(folder: Path, networks: Mapping[str, Network]) -> None:
    """Remove what an earlier run has left there, which would be taken for this one's.

    Those are cards and the files that they are of. What somebody else has put there, or made of
    such a file, stays.
    """
    for path in sorted((folder / FOLDER).glob("*.json")):
        if path.stem in networks or (card := _own(path)) is None:
            continue
        onnx = path.with_suffix(".onnx")
        if onnx.is_file() and digest(onnx.read_bytes()) == card.get("sha256"):
            onnx.unlink()
        path.unlink()


def _own(path: Path) -> dict[str, Any] | None:
    try:
        card: dict[str, Any] = json.loads(path.read_bytes())
        return card if card["format"] == FORMAT else None
    except (ValueError, TypeError, KeyError):
        # Somebody else's.
        return None
