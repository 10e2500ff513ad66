"""Reads data sets of `fabkit dataset` with Python's zarr and compares them, to the bit, with maps of `fabkit depth`.

    python check_dataset.py path/to/fabkit
"""

import json
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np
import zarr

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "fabkit/python/examples"))
from read_dataset import StitchedTruth  # noqa: E402

COUNT = 5
SET = ["--set", f"fixtures.semi_domes.count={COUNT}"]


def run(fabkit, *arguments):
    subprocess.run([fabkit, *map(str, arguments), "--quiet"], check=True)


def bits(array):
    """Reinterprets an array as unsigned integers, so that NaN compares equal and -0 differs from 0."""
    return array.view({1: np.uint8, 4: np.uint32, 8: np.uint64}[array.dtype.itemsize])


def same(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and np.array_equal(bits(a), bits(b))


# A camera that is rotated about its axis and shifted, so that the seam crosses chunks.
CROOKED = """camera_from_sensor:
- [0.9945218953682733, -0.10452846326765347, 0, 0.6]
- [0.10452846326765347, 0.9945218953682733, 0, 0]
- [0, 0, 1, 7]
- [0, 0, 0, 1]
"""
# Few pixels: for uncertainties, each pixel's ray is traced again for each parameter.
CAMERA = """fabkit_camera: 1
width_px: 96
height_px: 72
lens: {model: kannala-brandt, fx_px: 43, fy_px: 43, cx_px: 47.5, cy_px: 35.5, k1: 0, k2: 0, k3: 0, k4: 0}
"""
# The same pose with a covariance, as a calibration writes it.
UNSURE = CROOKED + """covariance:
  - [1.0e-6, 0, 0, 0, 0, 0]
  - [0, 1.0e-6, 0, 0, 0, 0]
  - [0, 0, 1.0e-6, 0, 0, 0]
  - [0, 0, 0, 1.0e-4, 0, 0]
  - [0, 0, 0, 0, 1.0e-4, 0]
  - [0, 0, 0, 0, 0, 1.0e-2]
"""


def captures(folder, names, shape):
    """Writes an image of noise for each half."""
    random = np.random.default_rng(1)
    folder.mkdir()
    for name in names:
        for side in ("left", "right"):
            write_png(folder / f"{name}-{side}.png", random.integers(1, 255, (*shape, 3), np.uint8))


def write_png(path, pixels):
    height, width, _ = pixels.shape

    def part(kind, content):
        return (struct.pack(">I", len(content)) + kind + content
                + struct.pack(">I", zlib.crc32(kind + content)))

    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", header)
                     + part(b"IDAT", zlib.compress(rows, 1)) + part(b"IEND", b""))


def check_halves(fabkit, folder, view):
    """Compares halves with single maps."""
    about = json.loads((folder / "lazy/dataset.json").read_text())
    names = [pattern["name"] for pattern in about["patterns"]]
    assert len(names) == COUNT
    lazy, written = (zarr.open(folder / name, mode="r") for name in ("lazy", "all"))
    reference = np.load(folder / "lazy/reference.npz")
    for half, press in enumerate(names + [f"{name}-flipped" for name in names]):
        file = folder / "map.npz"
        run(fabkit, "depth", "rtac0", "--press", press, "-o", file, *view)
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


def check_sigmas(fabkit, folder):
    """Compares standard deviations of halves with single maps; without a calibration there are none."""
    presses, pose, camera = (folder / name for name in ("presses.txt", "unsure.yaml", "camera.yaml"))
    camera.write_text(CAMERA)
    presses.write_text("semi-dome-001\n")
    pose.write_text(UNSURE)
    for name, view in (("sure", SET), ("unsure", [*SET, "--pose", pose])):
        view = [*view, "--camera", camera]
        run(fabkit, "dataset", "rtac0", "--presses", presses, "-o", folder / name, *view)
    sure, unsure = (zarr.open(folder / name, mode="r")["halves"] for name in ("sure", "unsure"))
    assert "indentation_sigma_mm" not in sure
    assert "point_sigma_mm" not in np.load(folder / "sure/reference.npz")
    file = folder / "map.npz"
    for half, press in enumerate(("semi-dome-001", "semi-dome-001-flipped")):
        run(fabkit, "depth", "rtac0", "--press", press, "--print-sigma", "0mm", "-o", file, *view)
        single = np.load(file)
        sigma = np.where(single["indentation_mm"] == 0, 0, single["indentation_sigma_mm"])
        sigma = np.nan_to_num(sigma).astype(np.float32)
        assert sigma.max() > 1e-4 and same(unsure["indentation_sigma_mm"][half], sigma), press
    run(fabkit, "depth", "rtac0", "--reference", "--print-sigma", "0mm", "-o", file, *view)
    single, reference = np.load(file), np.load(folder / "unsure/reference.npz")
    for name in ("sigma_mm", "point_sigma_mm", "normal_sigma_rad"):
        assert np.array_equal(reference[name], single[name], equal_nan=True), name
    print("check_dataset: how sure halves and their reference are: equal to the bit")


def check_samples(folder):
    """Compares samples that Python stitches with those that fabkit wrote."""
    written, arrays = zarr.open(folder / "all", mode="r"), set()
    for split in ("train", "validation", "test", "mixed"):
        truth = StitchedTruth(folder / "lazy", split)
        for index, (left, right) in enumerate(truth.halves_of):
            sample = left * COUNT + right - COUNT
            for name, stitched in truth[index].items():
                arrays.add(name)
                assert same(stitched, written[f"samples/{name}"][sample]), (sample, name)
    # Reading all at once must give the same: readers may merge neighbouring chunks of a file.
    for name in arrays:
        array = written[f"samples/{name}"]
        assert all(same(array[:][i], array[i]) for i in range(0, COUNT**2, 7)), name
    return written["samples/label"].chunks, sorted(arrays)


def check(fabkit, folder):
    pose = folder / "pose.yaml"
    pose.write_text(CROOKED)
    about = f"{COUNT} patterns, {2 * COUNT} maps, {COUNT**2} samples equal to the bit"
    for kind, view in (("straight", SET), ("crooked", [*SET, "--pose", pose])):
        place = folder / kind
        place.mkdir()
        pictures = []
        if kind == "crooked":
            names = [f"semi-dome-{number:03}" for number in range(1, COUNT + 1)]
            captures(place / "captures", names, (480, 640))
            pictures = ["--captures", place / "captures"]
        run(fabkit, "dataset", "rtac0", "-o", place / "lazy", *view, *pictures)
        run(fabkit, "dataset", "rtac0", "-o", place / "all", "--materialise", *view, *pictures)
        check_halves(fabkit, place, view)
        chunks, arrays = check_samples(place)
        print(f"check_dataset: {kind} seam: {about} in chunks of {chunks}: {', '.join(arrays)}")
        shutil.rmtree(place)
    check_sigmas(fabkit, folder)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        check(sys.argv[1], Path(folder))
