"""Data sets for PyTorch; requires ``pip install fabkit-cad[torch]``."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from fabkit import dataset

if TYPE_CHECKING:
    from os import PathLike

__all__ = ["TactileTruth"]


def __dir__() -> list[str]:
    return __all__


_torch: Any = importlib.import_module("torch")
_Dataset: Any = importlib.import_module("torch.utils.data").Dataset


class TactileTruth(_Dataset):
    """A data set of ``fabkit dataset`` as a map-style ``torch.utils.data.Dataset``.

    A sample is a dictionary of tensors: ``indentation_mm`` (1, rows, columns) float32, mm;
    ``contact`` (1, rows, columns) bool; and, with captures, ``image`` (channels, rows, columns)
    float32, 0 to 1.

    Parameters
    ----------
    folder, split
        As for :func:`fabkit.dataset.open`.
    """

    def __init__(self, folder: str | PathLike[str], split: dataset.Split | None = "train") -> None:
        self.truth = dataset.open(folder, split)
        """The data set, with samples as numpy arrays."""

    def __len__(self) -> int:
        return len(self.truth)

    def __getitem__(self, index: int) -> dict[str, Any]:
        sample = self.truth[index]
        tensors = {
            "indentation_mm": _torch.from_numpy(sample["indentation_mm"])[None],
            "contact": _torch.from_numpy(sample["label"] > 1)[None],
        }
        if "image" in sample:
            tensors["image"] = _torch.from_numpy(sample["image"]).permute(2, 0, 1) / 255
        return tensors
