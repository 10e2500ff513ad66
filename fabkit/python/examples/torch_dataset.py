"""Feeds a data set of `fabkit dataset` to PyTorch.

    pip install torch zarr numpy
    fabkit dataset rtac0 -o rtac0-truth
    python torch_dataset.py rtac0-truth
"""

import sys

import torch
from read_dataset import StitchedTruth
from torch.utils.data import DataLoader, Dataset


class TactileTruth(Dataset):
    """Indentation (1 x H x W, mm), mask of contact (1 x H x W) and, with captures, image (C x H x W, 0 to 1)."""

    def __init__(self, folder, split="train"):
        self.folder, self.split = folder, split
        self.count = len(StitchedTruth(folder, split))
        self.truth = None

    def __len__(self):
        return self.count

    def __getitem__(self, index):
        # Each worker opens the files itself: open stores do not travel between processes.
        self.truth = self.truth or StitchedTruth(self.folder, self.split)
        sample = self.truth[index]
        tensors = {
            "indentation_mm": torch.from_numpy(sample["indentation_mm"])[None],
            "contact": torch.from_numpy(sample["label"] > 1)[None],
        }
        if "image" in sample:
            tensors["image"] = torch.from_numpy(sample["image"]).permute(2, 0, 1) / 255
        return tensors


if __name__ == "__main__":
    loader = DataLoader(TactileTruth(sys.argv[1]), batch_size=8, shuffle=True, num_workers=2)
    batch = next(iter(loader))
    print({name: (tuple(tensor.shape), str(tensor.dtype)) for name, tensor in batch.items()})
