"""Data sets of ``fabkit dataset``: ground truth for all combinations of two half presses."""

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
    """Samples, each stitched from a left and a right half; see :func:`open`.

    Samples are read at access, and no file stays open, so the worker processes of a training can
    share it. Stored samples (``--materialise``) are read as they are; others are stitched from
    their halves, with the same result. Everything that is read is compared with its checksum; a
    damaged file is an error that names it.
    """

    def __init__(self, folder: str | PathLike[str], split: Split | None = None) -> None:
        self.folder = Path(folder)
        """Folder of the data set."""
        if split is not None and split not in _SPLITS:
            raise invalid(f"there is no split `{split}`", f"known: {', '.join(_SPLITS)}")
        self.split = split
        """``train``, ``validation``, ``test``, ``mixed``, or ``None`` for all."""
        files = _fabkit.DatasetReader(os.fspath(folder))
        self.about: dict[str, Any] = json.loads(files.document())
        """Content of ``dataset.json``: sensor, camera, units, frames, patterns, files."""
        rows = list(csv.DictReader(files.content("samples.csv").decode().splitlines()))
        chosen = [(i, row) for i, row in enumerate(rows) if split in (None, row["split"])]
        self.halves = np.array(
            [(int(row["left_half"]), int(row["right_half"])) for _, row in chosen], dtype=np.int64
        ).reshape(-1, 2)
        """Numbers of each sample's left and right half, (n, 2) int64."""
        self._stored = [i for i, _ in chosen]
        written: bool = self.about["materialised"]
        group = "samples" if written else "halves"
        names = ("indentation_mm", "label", "image")
        arrays = {name: files.array(f"{group}/{name}") for name in names}
        self._arrays = {name: array for name, array in arrays.items() if array is not None}
        self._materialised = written
        with np.load(io.BytesIO(files.content("reference.npz"))) as reference:
            self.reference: dict[str, NDArray[Any]] = dict(reference)
        """Maps without contact: ``range_mm``, points, normals; and the masks ``is_left`` and
        ``is_right`` of the two sides of the seam."""

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
        """Read a sample, or select several: ``data[10:20]``, ``data[::2]``, ``data[[3, -1]]``.

        Returns
        -------
        For a number, which counts from the end if it is negative, a dictionary of arrays:
        ``indentation_mm`` (rows, columns) float32, mm: range without contact minus range with it;
        ``label`` (rows, columns) uint8: 0 no surface or seam, 1 surface, from 2 on the indenters;
        and, with captures, ``image`` (rows, columns, channels) uint8. For a slice, a list of
        numbers or an array of booleans: a data set of these samples, which are not read yet.

        Raises
        ------
        IndexError
            The data set has no such sample.
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
            raise invalid(f"the index array has the dtype {index.dtype}; it must hold {wanted}")
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
        """Compute the range along each pixel's ray, (rows, columns) float64, mm.

        NaN where the ray does not meet the surface.
        """
        indentation_mm = self._read(self._arrays["indentation_mm"], self._place(index))
        return self.reference["range_mm"] - indentation_mm

    def _read(self, array: _fabkit.Samples, index: int) -> NDArray[Any]:
        if self._materialised:
            return array.sample(self._stored[index])
        left, right = (array.sample(int(half)) for half in self.halves[index])
        # Images have a third axis, for channels; the masks then need one of length 1.
        shape = self.reference["is_left"].shape + (1,) * (left.ndim - 2)
        empty = left.dtype.type(0)
        stitched = np.where(self.reference["is_right"].reshape(shape), right, empty)
        return np.where(self.reference["is_left"].reshape(shape), left, stitched)


def open(folder: str | PathLike[str], split: Split | None = None) -> Dataset:
    """Open a data set that ``fabkit dataset`` wrote.

    Parameters
    ----------
    folder
        Folder of the data set.
    split
        ``train``, ``validation`` or ``test``, which share no pattern; or ``mixed``: samples whose
        two patterns belong to different splits. ``None`` for all.

    Raises
    ------
    FabkitError
        The folder holds no data set, or an unfinished or damaged one.
    """
    return Dataset(folder, split)
