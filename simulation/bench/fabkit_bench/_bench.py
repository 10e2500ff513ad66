"""State and helpers that all experiments share: the design, seeds, prepared sensors, presses."""

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
    from fabkit_bench._onnx import OnnxNetwork

__all__ = ["Bench", "Family", "first_line", "press", "reference", "row_of_failure"]

T = TypeVar("T")

# Presses in one call: if one of them fails, all of them are repeated one by one.
_TOGETHER = 20


@dataclass(frozen=True)
class Family:
    """The experiments of a family of sensors."""

    experiments: dict[str, Callable[[Bench], list[Row]]]
    """Functions that compute the rows of each experiment, by name, in the order of the table."""
    figures: dict[str, Callable[[Bench], float]]
    """Functions that compute the metrics for sweeps, by name; intermediate results are shared."""
    quick: Any
    """Sizes (numbers of presses, epochs and the like) for a run of minutes."""
    full: Any
    """Sizes nearer to the paper's."""
    small: Any
    """Sizes for :attr:`figures`."""
    choices: tuple[str, ...]
    """Choices that the paper does not state, in words."""
    left_out: tuple[str, ...]
    """Experiments of the paper that are not run, in words."""
    plain: frozenset[str] = frozenset()
    """Names of experiments that need no scikit-learn."""
    deep: frozenset[str] = frozenset()
    """Names of experiments that need PyTorch: run with ``--full``, or when selected by name."""


class Bench:
    """State of one run, shared by its experiments."""

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
        self.notes: list[str] = []
        """Notes for the report, such as random draws and presses that were left out."""
        self.experiment = ""
        """Name of the running experiment."""
        self.networks: dict[str, Network] = {}
        """Trained networks to keep, by name."""
        self._keeps = keeps
        self._tell = tell
        self._made: dict[str, Any] = {}
        self._documents: list[dict[str, Any]] = []
        self._asked = 0

    def tell(self, what: str) -> None:
        """Report progress: ``what`` begins."""
        if self._tell is not None:
            self._tell(what)

    def keep(
        self, name: str, written: OnnxNetwork, card: Card, design: Sensor | None = None
    ) -> None:
        """Keep a network for the report, unless there is one of the name.

        With cross-validation that is the network of the first fold. ``design`` is the design that
        was pressed, if it is not the bench's own.
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
        """Create the random generator of one purpose, independent of all other purposes."""
        return np.random.default_rng([self.seed, zlib.crc32(of.encode())])

    def noise(self, of: str, count: int) -> list[int]:
        """Draw seeds for the noise of ``count`` images."""
        return [int(one) for one in self.random(f"noise of {of}").integers(2**31, size=count)]

    def once(self, name: str, make: Callable[[], T]) -> T:
        """Compute something at the first call with ``name`` and return it at later ones."""
        if name not in self._made:
            self._made[name] = make()
        return self._made[name]

    def folder(self) -> Path:
        """Return a temporary folder that lives as long as the bench; sensors reread its files."""
        kept = self.once("folder", lambda: tempfile.TemporaryDirectory(prefix="fabkit-bench-"))
        return Path(kept.name)

    def sensor(self, design: Sensor | None = None, **options: Any) -> sim.Sensor:
        """Prepare a sensor for presses, and record the assumptions of its images."""
        ready = sim.Sensor(design or self.design, **options)
        self._documents.append(ready.document)
        return ready

    def document(self) -> dict[str, Any]:
        """Return the constants of the first sensor, and what any sensor's simulation leaves out."""
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
        """Simulate presses and leave out impossible ones.

        Returns the results of the others, with their indices in ``asked``.
        """
        many, kept, lost = press(sensor, asked)
        if lost:
            of = f"{len(asked) - len(kept)} of {len(asked)} presses left out"
            self.notes.append(f"{of}: {lost[0]}")
        return many, kept


def press(sensor: sim.Sensor, asked: Sequence[sim.Asked]) -> tuple[sim.Many, list[int], list[str]]:
    """Simulate presses in groups, and one by one where a group fails.

    Returns
    -------
    The results, the indices of the presses that succeeded, and the errors of the others.

    Raises
    ------
    FabkitError
        No press succeeds; the error is that of the first one.
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
    """Take the mean of several reference images: h x w, or h x w x 3 in colour."""
    seeds = bench.noise(f"reference of {of}", pictures)
    at_rest = sensor.press_all([sim.Asked(seed=seed) for seed in seeds])
    mean: NDArray[np.float64] = at_rest.image.mean(axis=0)
    return np.round(mean).astype(np.uint8)


def first_line(error: FabkitError) -> str:
    """Return the error's message without hints."""
    return str(error).splitlines()[0]


def row_of_failure(name: str, error: FabkitError) -> Row:
    """Create the table row of an experiment that could not be run."""
    return Row(name, "", None, None, None, 0, f"could not be run: {first_line(error)}", name)
