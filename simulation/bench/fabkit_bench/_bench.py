"""What every experiment uses: a design, seeds, sensors that are made ready once, presses."""

from __future__ import annotations

import re
import tempfile
import zlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from fabkit import sim
from fabkit.errors import FabkitError
from fabkit_bench._networks import FORMAT, Card, Network
from fabkit_bench._report import Row

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from fabkit.designs import Sensor
    from fabkit_bench._onnx import Written

__all__ = ["Bench", "Family", "first_line", "press", "reference", "row_of_failure"]

T = TypeVar("T")

# Where one of some cannot be pressed, all of them are pressed again, one by one.
_TOGETHER = 20


@dataclass(frozen=True)
class Family:
    """The experiments of a family of sensors."""

    experiments: dict[str, Callable[[Bench], list[Row]]]
    """By name, in the order of the table."""
    figures: dict[str, Callable[[Bench], float]]
    """The few that tell designs apart, by name; what they share is made once."""
    quick: Any
    """Counts for minutes."""
    full: Any
    """Counts nearer to the paper's."""
    small: Any
    """Counts for :attr:`figures`."""
    choices: tuple[str, ...]
    """What is chosen, in words."""
    left_out: tuple[str, ...]
    """What of the paper is not run."""
    plain: frozenset[str] = frozenset()
    """Experiments that need no scikit-learn."""
    deep: frozenset[str] = frozenset()
    """Those that need PyTorch: they are run in full, and when asked for by name."""


class Bench:
    """One run: what experiments share."""

    def __init__(
        self,
        design: Sensor,
        seed: int,
        size: Any,
        tell: Callable[[str], None] | None,
        *,
        keeps: bool = True,
    ) -> None:
        self.design = design
        self.seed = seed
        self.size = size
        self.said: list[str] = []
        """What was drawn, for the report."""
        self.experiment = ""
        """The one that runs."""
        self.networks: dict[str, Network] = {}
        """What was trained and is kept, by name."""
        self._keeps = keeps
        self._tell = tell
        self._made: dict[str, Any] = {}
        self._documents: list[dict[str, Any]] = []
        self._asked = 0

    def tell(self, what: str) -> None:
        """Say what begins."""
        if self._tell is not None:
            self._tell(what)

    def keep(self, name: str, written: Written, card: Card, design: Sensor | None = None) -> None:
        """Keep a network for the report: the first of its name, which is that of the first fold.

        ``design`` is what was pressed, where that is not the bench's own.
        """
        name = re.sub("[^a-z0-9]+", "-", name.lower()).strip("-")
        if not self._keeps or name in self.networks:
            return
        design = design or self.design
        about = {
            "format": FORMAT,
            "version": 1,
            "name": name,
            "sensor": design.name,
            "design_hash": design.design_hash,
            "seed": self.seed,
            "experiment": self.experiment,
            "is_simulated": True,
        }
        self.networks[name] = Network(written.onnx, {**about, **card.document(written)})

    def random(self, of: str) -> np.random.Generator:
        """Make the source of random numbers of one purpose: others do not change what it gives."""
        return np.random.default_rng([self.seed, zlib.crc32(of.encode())])

    def noise(self, of: str, count: int) -> list[int]:
        """Draw seeds of pictures' noise."""
        return [int(one) for one in self.random(f"noise of {of}").integers(2**31, size=count)]

    def once(self, name: str, make: Callable[[], T]) -> T:
        """Make something that several experiments need, the first time one asks."""
        if name not in self._made:
            self._made[name] = make()
        return self._made[name]

    def folder(self) -> Path:
        """Make a folder that lasts as long as this does: sensors read their files again."""
        kept = self.once("folder", lambda: tempfile.TemporaryDirectory(prefix="fabkit-bench-"))
        return Path(kept.name)

    def sensor(self, design: Sensor | None = None, **options: Any) -> sim.Sensor:
        """Make a sensor ready, and remember what its pictures rest on."""
        ready = sim.Sensor(design or self.design, **options)
        self._documents.append(ready.document)
        return ready

    def document(self) -> dict[str, Any]:
        """Tell what the first sensor's pictures rest on, and what any of them leave out."""
        first: dict[str, Any] = self._documents[0] if self._documents else {}
        left_out = [
            f"{what}, of {one}" if one else what
            for document in self._documents
            for key, one in (("left_out", ""), ("layers_left_out", "layers"))
            for what in document.get(key, ())
        ]
        return {
            "constants": first.get("constants", []),
            "left_out": list(dict.fromkeys(left_out)),
        }

    def press(self, sensor: sim.Sensor, asked: Sequence[sim.Asked]) -> tuple[sim.Many, list[int]]:
        """Press, and leave out what cannot be: the rest, and the numbers of the presses kept."""
        many, kept, lost = press(sensor, asked)
        if lost:
            of = f"{len(asked) - len(kept)} of {len(asked)} presses left out"
            self.said.append(f"{of}: {lost[0]}")
        return many, kept


def press(sensor: sim.Sensor, asked: Sequence[sim.Asked]) -> tuple[sim.Many, list[int], list[str]]:
    """Press some at once, one by one where that fails.

    Returns
    -------
    What they do, the numbers of those that could be, and why the others could not.

    Raises
    ------
    FabkitError
        That of the first press, where none can be.
    """
    done: list[sim.Many] = []
    kept: list[int] = []
    lost: list[FabkitError] = []
    for start in range(0, len(asked), _TOGETHER):
        some = list(asked[start : start + _TOGETHER])
        try:
            done.append(sensor.press_all(some))
            kept += range(start, start + len(some))
        except FabkitError:
            for k, one in enumerate(some):
                try:
                    done.append(sensor.press_all([one]))
                    kept.append(start + k)
                except FabkitError as error:
                    lost.append(error)
    if not done:
        raise lost[0]
    joined = {
        field.name: np.concatenate([getattr(one, field.name) for one in done])
        for field in fields(sim.Many)
    }
    return sim.Many(**joined), kept, [first_line(error) for error in lost]


def reference(bench: Bench, sensor: sim.Sensor, of: str, pictures: int = 10) -> NDArray[np.uint8]:
    """Take the mean of some pictures at rest: h x w, and colours where there are."""
    seeds = bench.noise(f"reference of {of}", pictures)
    at_rest = sensor.press_all([sim.Asked(seed=seed) for seed in seeds])
    mean: NDArray[np.float64] = at_rest.image.mean(axis=0)
    return np.round(mean).astype(np.uint8)


def first_line(error: FabkitError) -> str:
    """Say what went wrong, without hints."""
    return str(error).splitlines()[0]


def row_of_failure(name: str, error: FabkitError) -> Row:
    """Say in the table that an experiment could not be run."""
    return Row(name, "", None, None, None, 0, f"could not be run: {first_line(error)}", name)
