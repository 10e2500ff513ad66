"""Reads a data set that `fabkit dataset` wrote, without PyTorch.

    pip install zarr numpy
    fabkit dataset rtac0 -o rtac0-truth
    python read_dataset.py rtac0-truth
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
import zarr


class StitchedTruth:
    """Samples of one split: indentation and label, stitched on the fly from two halves.

    Indentation is in mm, float32, rows x columns; labels are what dataset.json says.
    """

    def __init__(self, folder, split="train"):
        folder = Path(folder)
        self.about = json.loads((folder / "dataset.json").read_text())
        halves = zarr.open(folder / "halves", mode="r")
        self.indentation_mm = halves["indentation_mm"]
        self.label = halves["label"]
        self.image = halves["image"] if (folder / "halves/image").exists() else None
        reference = np.load(folder / "reference.npz")
        self.reference_range_mm = reference["range_mm"]
        self.is_left, self.is_right = reference["is_left"], reference["is_right"]
        with open(folder / "samples.csv", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["split"] == split]
        self.halves_of = [(int(row["left_half"]), int(row["right_half"])) for row in rows]

    def __len__(self):
        return len(self.halves_of)

    def __getitem__(self, index):
        left, right = self.halves_of[index]
        return {
            "indentation_mm": self._stitched(self.indentation_mm, left, right),
            "label": self._stitched(self.label, left, right),
            **({} if self.image is None else {"image": self._stitched(self.image, left, right)}),
        }

    def range_mm(self, index):
        """Distance along each pixel's ray, mm; NaN where no surface is seen."""
        return self.reference_range_mm - self[index]["indentation_mm"]

    def _stitched(self, halves, left, right):
        left, right = halves[left], halves[right]
        # Pictures have a third axis.
        shape = self.is_left.shape + (1,) * (left.ndim - 2)
        empty = left.dtype.type(0)
        stitched = np.where(self.is_right.reshape(shape), right, empty)
        return np.where(self.is_left.reshape(shape), left, stitched)


if __name__ == "__main__":
    truth = StitchedTruth(sys.argv[1], *sys.argv[2:3])
    print(f"{len(truth)} samples of {truth.about['about']['sensor']}")
    if len(truth):
        sample = truth[0]
        print({name: (array.shape, str(array.dtype)) for name, array in sample.items()})
        print(f"deepest: {sample['indentation_mm'].max():.3f} mm")
