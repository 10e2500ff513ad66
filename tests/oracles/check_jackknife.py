"""Compares the claimed uncertainty of ground truth with the jackknife: each capture is left out of the calibration.

    python check_jackknife.py path/to/fabkit CAPTURES

CAPTURES is a folder of R-Tac0's published captures: images named after their holes, ref.png, holes.json. On demand: the
calibrations take a minute for each four captures.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

CAMERA = Path(__file__).parent.parent / "end_to_end" / "data" / "rtac0_opencv_camera.yaml"
PRESSES = {"at rest": ["--reference"], "pressed 1.2 mm": ["--press", "hemisphere@30deg,120deg,1.2mm"]}
# Compared maps, and their claimed standard deviations.
TRUTHS = {"range_mm": "sigma_mm", "point_in_sensor": "point_sigma_mm", "indentation_mm": "indentation_sigma_mm",
          "normal_in_sensor": "normal_sigma_rad"}


def run(fabkit: str, *words: Any) -> dict[str, Any]:
    done = subprocess.run([fabkit, *map(str, words), "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def truths(fabkit: str, captures: Path, pictures: list[Path], folder: Path) -> dict[str, Any]:
    """Calibrates from some of the images and casts ground truth; returns the chosen model and the maps."""
    taken = folder / "captures"
    shutil.rmtree(taken, ignore_errors=True)
    taken.mkdir()
    for picture in [*pictures, captures / "ref.png"]:
        shutil.copy(picture, taken)
    report = run(fabkit, "calibrate", "extrinsics", "rtac0", "--camera", CAMERA, "--captures", taken,
                 "--landmarks", captures / "holes.json", "-o", folder / "pose.yaml", "--force")
    found = {"model": report["model"]["name"]}
    for name, press in PRESSES.items():
        run(fabkit, "depth", "rtac0", *press, "--pose", folder / "pose.yaml", "--print-sigma", "0mm",
            "-o", folder / "truth.npz")
        with np.load(folder / "truth.npz") as maps:
            found[name] = {key: maps[key] for key in ("label", *TRUTHS, *TRUTHS.values())}
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fabkit")
    parser.add_argument("captures", type=Path)
    args = parser.parse_args()
    pictures = sorted(path for path in args.captures.glob("*.png") if path.name != "ref.png")
    count = len(pictures)
    with tempfile.TemporaryDirectory() as folder:
        whole = truths(args.fabkit, args.captures, pictures, Path(folder))
        parts = [truths(args.fabkit, args.captures, [p for p in pictures if p != left_out], Path(folder))
                 for left_out in pictures]
    print(f"all: {whole['model']}; without one: {sorted(part['model'] for part in parts)}")
    for name in PRESSES:
        labels = np.stack([part[name]["label"] for part in [whole, *parts]])
        same = (labels == labels[0]).all(0) & (labels[0] > 0)
        for truth, sigma in TRUTHS.items():
            values = np.stack([part[name][truth] for part in parts]).reshape(count, *same.shape, -1)
            squares = ((values - values.mean(0)) ** 2).sum(0).sum(-1)
            # Jackknife variance of Quenouille and Tukey: (n - 1) / n times the sum of squares.
            found, claimed = np.sqrt((count - 1) / count * squares), whole[name][sigma]
            told = same & np.isfinite(found) & (claimed > 1e-9)
            if not told.any():
                continue
            ratio = np.percentile(found[told] / claimed[told], [5, 50, 95])
            print(f"{name}: {truth}: claimed {np.median(claimed[told]):.4f}, without each {np.median(found[told]):.4f}, "
                  f"ratio {ratio[1]:.2f} ({ratio[0]:.2f} to {ratio[2]:.2f} over 90 % of {told.sum()} pixels)")


if __name__ == "__main__":
    main()
