"""Reads what `fabkit dataset` writes with Python's zarr and compares it, to the bit, with the maps
that `fabkit depth` writes for the same presses.

    python check_dataset.py path/to/fabkit
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import zarr

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python/examples"))
from read_dataset import StitchedTruth  # noqa: E402

COUNT = 5
SET = ["--set", f"fixtures.semi_domes.count={COUNT}"]


def run(fabkit, *arguments):
    subprocess.run([fabkit, *map(str, arguments), "--quiet"], check=True)


def bits(array):
    return array.view({1: np.uint8, 4: np.uint32, 8: np.uint64}[array.dtype.itemsize])


def same(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(bits(a), bits(b))


def check(fabkit, folder):
    run(fabkit, "dataset", "rtac0", "-o", folder / "lazy", *SET)
    run(fabkit, "dataset", "rtac0", "-o", folder / "all", "--materialise", *SET)
    about = json.loads((folder / "lazy/dataset.json").read_text())
    names = [pattern["name"] for pattern in about["patterns"]]
    assert len(names) == COUNT

    # Halves against single maps.
    lazy, written = (zarr.open(folder / name, mode="r") for name in ("lazy", "all"))
    reference = np.load(folder / "lazy/reference.npz")
    for half, press in enumerate(names + [f"{name}-flipped" for name in names]):
        file = folder / "map.npz"
        run(fabkit, "depth", "rtac0", "--press", press, "-o", file, *SET)
        single = np.load(file)
        indentation = np.nan_to_num(single["indentation_mm"], nan=0.0).astype(np.float32)
        for dataset in (lazy, written):
            assert same(dataset["halves/indentation_mm"][half], indentation), press
            assert np.array_equal(dataset["halves/label"][half], single["label"]), press
        assert [*single["label_names"]][2:] == about["patterns"][half % COUNT]["bodies"]
        seen = np.isfinite(reference["range_mm"])
        assert np.array_equal(seen, single["label"] > 0)
        restored = (reference["range_mm"] - single["indentation_mm"])[seen]
        assert np.allclose(restored, single["range_mm"][seen], rtol=0, atol=1e-12)

    # Stitched by Python and by fabkit.
    for split in ("train", "validation", "test", "mixed"):
        truth = StitchedTruth(folder / "lazy", split)
        for index, (left, right) in enumerate(truth.halves_of):
            sample = left * COUNT + right - COUNT
            for name, stitched in truth[index].items():
                assert same(stitched, written[f"samples/{name}"][sample]), (sample, name)
    print(f"check_dataset: {COUNT} patterns, {2 * COUNT} maps, {COUNT**2} samples equal to the bit")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        check(sys.argv[1], Path(folder))
