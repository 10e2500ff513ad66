"""Data sets of ``fabkit dataset``: training targets for all combinations of two half presses."""

from __future__ import annotations

import copy
import csv
import io
import json
import operator
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, SupportsIndex, overload

import numpy as np

from fabkit import _fabkit
from fabkit._dataset import write
from fabkit.errors import invalid

if TYPE_CHECKING:
    from collections.abc import Iterator
    from os import PathLike

    from numpy.typing import NDArray

    Split = Literal["train", "validation", "test", "mixed"]

__all__ = ["Dataset", "open", "write"]


def __dir__() -> list[str]:
    return __all__


_SPLITS = ("train", "validation", "test", "mixed")


class Dataset:
    """Samples, each of a left and a right half; see :func:`open`.

    Nothing is read before it is asked for, and nothing stays open, so that processes that a
    training starts can share it. Samples that were written (``--materialise``) are read as they
    are; others are stitched from their halves, which gives the same. What is read is compared with
    its checksums; damage is an error that names the file.
    """

    def __init__(self, folder: str | PathLike[str], split: Split | None = None) -> None:
        self.folder = Path(folder)
        """Where it is."""
        if split is not None and split not in _SPLITS:
            raise invalid(f"there is no split `{split}`", f"known: {', '.join(_SPLITS)}")
        self.split = split
        """``train``, ``validation``, ``test``, ``mixed``, or ``None`` for all."""
        files = _fabkit.DatasetReader(os.fspath(folder))
        self.about: dict[str, Any] = json.loads(files.document())
        """Everything that ``dataset.json`` says: sensor, camera, units, frames, patterns, files."""
        rows = list(csv.DictReader(files.content("samples.csv").decode().splitlines()))
        chosen = [(i, row) for i, row in enumerate(rows) if split in (None, row["split"])]
        self.halves = np.array(
            [(int(row["left_half"]), int(row["right_half"])) for _, row in chosen], dtype=np.int64
        ).reshape(-1, 2)
        """The half on the left and the one on the right of each sample, (n, 2) int64."""
        self._stored = [i for i, _ in chosen]
        written: bool = self.about["materialised"]
        group = "samples" if written else "halves"
        names = ("indentation_mm", "label", "image")
        arrays = {name: files.array(f"{group}/{name}") for name in names}
        self._arrays = {name: array for name, array in arrays.items() if array is not None}
        self._materialised = written
        with np.load(io.BytesIO(files.content("reference.npz"))) as reference:
            self.reference: dict[str, NDArray[Any]] = dict(reference)
        """Without contact: ``range_mm``, points, normals; ``is_left`` and ``is_right`` of the
        seam."""

    def __repr__(self) -> str:
        kind = "materialised" if self._materialised else "stitched when read"
        return (
            f"<Dataset {self.folder}: {len(self)} samples of {self.split or 'all splits'}, {kind}>"
        )

    def __len__(self) -> int:
        return len(self._stored)

    def __iter__(self) -> Iterator[dict[str, NDArray[Any]]]:
        return (self[i] for i in range(len(self)))

    @overload
    def __getitem__(self, index: SupportsIndex) -> dict[str, NDArray[Any]]: ...

    @overload
    def __getitem__(self, index: slice | Sequence[int] | NDArray[Any]) -> Dataset: ...

    def __getitem__(
        self, index: SupportsIndex | slice | Sequence[int] | NDArray[Any]
    ) -> dict[str, NDArray[Any]] | Dataset:
        """Read a sample, or choose several: ``data[10:20]``, ``data[::2]``, ``data[[3, -1]]``.

        Returns
        -------
        Of a number, counted from the end if it is negative: ``indentation_mm`` (rows, columns)
        float32, mm: range without contact minus range with it; ``label`` (rows, columns) uint8: 0
        no surface or seam, 1 surface, from 2 on what presses; and, with captures, ``image`` (rows,
        columns, channels) uint8. Of a slice, a list of numbers or an array of booleans: a data set
        of these samples, of which nothing is read yet.

        Raises
        ------
        IndexError
            No such sample.
        """
        if isinstance(index, slice):
            return self._chosen(range(len(self))[index])
        if isinstance(index, np.ndarray | Sequence):
            return self._chosen(self._places(np.asarray(index)))
        place = self._place(operator.index(index))
        return {name: self._read(array, place) for name, array in self._arrays.items()}

    def _places(self, index: NDArray[Any]) -> list[int]:
        if index.dtype == np.bool_ and index.shape == (len(self),):
            return np.flatnonzero(index).tolist()
        if index.ndim != 1 or (index.size and index.dtype.kind not in "iu"):
            wanted = f"whole numbers, or {len(self)} booleans"
            raise invalid(f"samples are chosen by an array of {index.dtype}; it must be {wanted}")
        return [self._place(int(place)) for place in index]

    def _place(self, index: int) -> int:
        if not -len(self) <= index < len(self):
            raise IndexError(f"there is no sample {index}; there are {len(self)}")
        return index % len(self)

    def _chosen(self, places: Sequence[int]) -> Dataset:
        part = copy.copy(self)
        part.halves = self.halves[list(places)]
        part._stored = [self._stored[place] for place in places]
        return part

    def range_mm(self, index: int) -> NDArray[np.float64]:
        """Distance along each pixel's ray, (rows, columns) float64, mm; NaN where none ends."""
        indentation_mm = self._read(self._arrays["indentation_mm"], self._place(index))
        return self.reference["range_mm"] - indentation_mm

    def _read(self, array: _fabkit.Samples, index: int) -> NDArray[Any]:
        if self._materialised:
            return array.sample(self._stored[index])
        left, right = (array.sample(int(half)) for half in self.halves[index])
        # Pictures have a third axis.
        shape = self.reference["is_left"].shape + (1,) * (left.ndim - 2)
        empty = left.dtype.type(0)
        stitched = np.where(self.reference["is_right"].reshape(shape), right, empty)
        return np.where(self.reference["is_left"].reshape(shape), left, stitched)


def open(folder: str | PathLike[str], split: Split | None = None) -> Dataset:
    """Open a data set that ``fabkit dataset`` wrote.

    Parameters
    ----------
    folder
        Its folder.
    split
        ``train``, ``validation`` or ``test``, which share no pattern, or ``mixed``: samples of
        patterns that are for different things; ``None`` for all.

    Raises
    ------
    FabkitError
        No data set there, an unfinished or a damaged one.
    """
    return Dataset(folder, split)
