"""Renders from optics packs as simulators do, and compares the images with fabkit's own captures.

    python check_optics.py path/to/fabkit [SENSOR ...]

For light that shows slopes: from the depth of the deformed surface, pixel by pixel, through the table, as Taxim, TacEx
and TacSL do (Si and Yuan 2022: bins of slope angle and direction, polynomials of the pixel, plus the reference image).
For light that shows thickness: from the darkening of a pressed pixel through the table of intensity to depth. All of
it is simulated.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[Any]
# A press of a ball for each sensor.
SLOPES = {"digit-like": "ball@3mm,-2mm,0.4mm", "gelsight-like": "ball@-2mm,1mm,0.4mm"}
DEPTHS = {"9dtact": "ball@0mm,0mm,1mm", "rtac0": "ball@0deg,0deg,0.7mm"}
# Least and largest slope of compared pixels, rad.
SLOPE_RAD = (0.05, 0.5)
# Largest rms error over the rms change by slopes: the table has no shadows, one pixel size, and second degree only.
MISSED = 0.3
# Largest relative error of depth: lateral scatter in the layer, 0.4 mm, brightens the middle of an indentation.
DEPTH = 0.15


def run(fabkit: str, *words: Any) -> None:
    subprocess.run([fabkit, *map(str, words), "--quiet"], check=True)


def picture(path: Path) -> Array:
    with Image.open(path) as image:
        return np.asarray(image).astype(float)


def tables(folder: Path) -> dict[str, Any]:
    """Reads TacSL's tables, and checks that Taxim's are the same with reversed colours."""
    with np.load(folder / "taxim/polycalib.npz") as taxim, np.load(folder / "tacsl/polycalib.npz") as tacsl:
        assert int(taxim["bins"]) == 125 and taxim["grad_r"].shape == (125, 125, 6)
        assert all((taxim[f"grad_{a}"] == tacsl[f"grad_{b}"]).all() for a, b in ("rb", "gg", "br"))
        grads = np.stack([tacsl[f"grad_{color}"] for color in "rgb"])
    background = picture(folder / "background.png")
    with np.load(folder / "taxim/dataPack.npz", allow_pickle=True) as pack:
        assert (pack["f0"][..., ::-1] == background).all()
    # JPEG of the best quality still rounds.
    assert np.abs(picture(folder / "tacsl/bg.jpg") - background).max() <= 4
    with np.load(folder / "taxim/shadowTable.npz", allow_pickle=True) as shadows:
        ways, lists = shadows["shadowDirections"], shadows["shadowTable"]
        assert ways.shape == (63,) and lists.shape == (3, 63, 24)
        # Higher edges cast longer shadows, if any, and shadows are negative changes.
        lengths = np.vectorize(len)(lists)
        assert (np.diff(lengths, axis=2) >= 0).all()
        assert max(max(list_, default=-1.0) for list_ in lists.ravel()) <= -1.0
    gelmap = np.load(folder / "taxim/gelmap.npy")
    assert gelmap.shape == background.shape[:2] and (gelmap == 0).all()
    params = json.loads((folder / "taxim/params.json").read_text())["sensor"]
    config = json.loads((folder / "tacsl/render_cfg.json").read_text())
    assert params["pixmm"] == config["mm_per_pixel"] and params["num_bins"] == config["num_bins"]
    return {"grads": grads, "background": background, "pixmm": params["pixmm"]}


def drawn(table: dict[str, Any], height_mm: Array) -> tuple[Array, Array]:
    """Renders heights towards the camera by the table; returns the image and the slope angles, rad."""
    down, right = np.gradient(height_mm / table["pixmm"])
    angle, way = np.arctan(np.hypot(down, right)), np.arctan2(down, right)
    first = np.floor(angle / (np.pi / 2 / 124)).astype(int)
    second = np.floor((way + np.pi) / (2 * np.pi / 124)).astype(int)
    y, x = np.mgrid[: height_mm.shape[0], : height_mm.shape[1]]
    terms = np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=-1)
    changes = [(terms * grads[first, second]).sum(axis=-1) for grads in table["grads"]]
    return table["background"] + np.stack(changes, axis=-1), angle


def slopes(fabkit: str, sensor: str, press: str, folder: Path) -> bool:
    run(fabkit, "optics-pack", sensor, "-o", folder / sensor)
    table = tables(folder / sensor)
    run(fabkit, "capture", sensor, "--press", press, "--no-noise", "-o", folder / "a.png",
        "--truth", folder / "a.npz")
    with np.load(folder / "a.npz") as truth:
        point = truth["point_in_sensor"][..., 2]
    # The pad is flat, perpendicular to z; NaN beside it.
    rest = np.nanmedian(point)
    height_mm = np.nan_to_num(rest - point)
    by_table, angle = drawn(table, height_mm)
    own = picture(folder / "a.png")
    # Leave out pixels that are or were as dark as a marker: the table does not model markers.
    unmarked = np.minimum(own.max(axis=-1), table["background"].max(axis=-1)) > 30
    inside = (angle > SLOPE_RAD[0]) & (angle < SLOPE_RAD[1]) & unmarked
    change = (own - table["background"])[inside]
    left = (own - by_table)[inside]
    part = float(np.sqrt((left**2).mean() / (change**2).mean()))
    alike = float(np.corrcoef(change.ravel(), (by_table - table["background"])[inside].ravel())[0, 1])
    print(f"check_optics: {sensor} {press}: {inside.sum()} pixels change by "
          f"{np.sqrt((change**2).mean()):.1f} grey rms; the table misses {np.sqrt((left**2).mean()):.1f} "
          f"({100 * part:.0f} %), correlation {alike:.3f}")
    return part < MISSED


def depths(fabkit: str, sensor: str, press: str, folder: Path) -> bool:
    run(fabkit, "optics-pack", sensor, "-o", folder / sensor)
    with np.load(folder / sensor / "grey_to_depth.npz") as table:
        grey, depth_mm = table["darker_grey"], table["depth_mm"]
    rest = picture(folder / sensor / "background.png")[..., 0]
    run(fabkit, "capture", sensor, "--press", press, "--no-noise", "--bits", 16, "-o", folder / "a.png",
        "--truth", folder / "a.npz")
    with np.load(folder / "a.npz") as truth:
        indentation = truth["indentation_mm"]
    deep = indentation > 0.8 * np.nanmax(indentation)
    darker = (rest - picture(folder / "a.png") / 257)[deep]
    read_mm = np.interp(darker, grey, depth_mm[0])
    off = read_mm - indentation[deep]
    print(f"check_optics: {sensor} {press}: {deep.sum()} deepest pixels read {read_mm.mean():.3f} mm, "
          f"truth {indentation[deep].mean():.3f} mm")
    return abs(float(off.mean())) < DEPTH * float(indentation[deep].mean())


def main(fabkit: str, sensors: list[str]) -> int:
    fine = True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for sensor, press in SLOPES.items():
            if sensor in sensors or not sensors:
                fine &= slopes(fabkit, sensor, press, folder)
        for sensor, press in DEPTHS.items():
            if sensor in sensors or not sensors:
                fine &= depths(fabkit, sensor, press, folder)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main(str(Path(sys.argv[1]).resolve()), sys.argv[2:]))
