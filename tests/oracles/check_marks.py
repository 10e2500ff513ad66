"""Calibrates R-Tac0 from simulated captures of pins and measures the errors of camera and surface.

    python check_marks.py path/to/fabkit [--captures N]

The captures use three sets of light constants that the solver does not know. On demand: 30 captures with each take
some minutes.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

PINS = 5
# Least distance between pins, mm: the images of nearer ones merge.
APART_MM = 6.0
# Holes behind the shell's rim.
HIDDEN = {24, 28}
# Intensity of an infinitely thick layer, intensity from elsewhere, scatter in 1/mm, spread in mm.
LIGHTS = {"as assumed": None, "more scatter, less spread": (250, 60, 0.39, 0.25),
          "much more scatter, more spread": (180, 20, 1.0, 0.5)}
NAMES = ("layer_grey", "ground_grey", "scatter_per_mm", "spread_mm")


def run(fabkit: str, *words: Any) -> str:
    return subprocess.run([fabkit, *map(str, words)], check=True, capture_output=True, text=True).stdout


def camera_file(fabkit: str, folder: Path) -> Path:
    """Writes the design's lens as a camera file, as if it had been calibrated in air."""
    run(fabkit, "export", "rtac0", "--format", "light", "-o", folder / "light")
    camera = json.loads((folder / "light/light.json").read_text())["camera"]
    lines = ["fabkit_camera: 1", f"width_px: {camera['width_px']}", f"height_px: {camera['height_px']}", "lens:",
             f"  model: {camera['lens']}", *(f"  {name}: {value!r}" for name, value in camera["parameters"].items())]
    (folder / "camera.yaml").write_text("\n".join(lines) + "\n")
    return folder / "camera.yaml"


def captures(fabkit: str, folder: Path, light: tuple[float, ...] | None, pins: list[dict[str, Any]], count: int) -> None:
    """Simulates captures of random pins and the reference image into a new folder, with a list of the pins."""
    folder.mkdir()
    constants = []
    if light:
        document = {"format": "fabkit-fit-light", "version": 1, "captures": 3, "held_out_profile_rms_grey": 0.5,
                    "constants": [{"name": name, "value": value} for name, value in zip(NAMES, light, strict=True)]}
        (folder / "light.json").write_text(json.dumps(document))
        constants = ["--constants", folder / "light.json"]
    chance = random.Random(str(light))
    rows, jobs = ["file,hole,kind"], []
    for capture in range(count):
        chosen: list[dict[str, Any]] = []
        while len(chosen) < PINS:
            pin = chance.choice(pins)
            apart = all(math.dist(pin["contact_in_sensor_mm"], o["contact_in_sensor_mm"]) > APART_MM for o in chosen)
            if pin["hole"] not in HIDDEN and apart:
                chosen.append(pin)
        rows += [f"{capture}.png,{pin['hole']},{pin['kind']}" for pin in chosen]
        presses = [word for pin in chosen for word in ("--press", f"pin-{pin['hole']}-{pin['kind']}")]
        jobs.append(["capture", "rtac0", "--seed", capture, *presses, *constants, "-o", folder / f"{capture}.png"])
    jobs.append(["capture", "rtac0", "--reference", "--seed", count, *constants, "-o", folder / "ref.png"])
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda job: run(fabkit, *job), jobs))
    (folder / "captures.csv").write_text("\n".join(rows) + "\n")


def surface(fabkit: str, folder: Path, *words: Any) -> np.ndarray:
    """Returns the surface point that each pixel sees at rest, sensor frame, mm."""
    run(fabkit, "depth", "rtac0", "--reference", *words, "-o", folder / "depth.npz")
    with np.load(folder / "depth.npz") as found:
        return found["point_in_sensor"]


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("fabkit")
    parser.add_argument("--captures", type=int, default=30)
    asked = parser.parse_args()
    fabkit, fine = str(Path(asked.fabkit).resolve()), True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        camera = camera_file(fabkit, folder)
        run(fabkit, "export", "rtac0/pin-dome", "-o", folder / "dome")
        pins = json.loads((folder / "dome/pin-dome.landmarks.json").read_text())["pins"]
        truth = surface(fabkit, folder)
        for i, (what, light) in enumerate(LIGHTS.items()):
            captures(fabkit, folder / str(i), light, pins, asked.captures)
            pose = folder / f"pose-{i}.yaml"
            said = json.loads(run(fabkit, "calibrate", "extrinsics", "rtac0", "--camera", camera, "--captures",
                                  folder / str(i), "-o", pose, "--json"))
            found = surface(fabkit, folder, "--camera", folder / f"pose-{i}.camera.yaml", "--pose", pose)
            off = np.linalg.norm(found - truth, axis=-1)
            off = off[np.isfinite(off)]
            z, sigma = said["camera_from_sensor"][2][3], math.sqrt(said["covariance"][5][5])
            print(f"check_marks: {what}: {said['model']['name']}, held out {said['held_out_rms_px']:.2f} px; z off by "
                  f"{z - 7.0:+.3f} mm, {abs(z - 7.0) / sigma:.1f} sigma; surface off by "
                  f"{math.sqrt((off**2).mean()):.3f} mm rms, median {np.median(off):.3f}; jackknife over claimed "
                  f"{[round(ratio, 2) for ratio in said['jackknife_ratio']]}")
            fine &= abs(z - 7.0) < 3 * sigma and said["within_tolerances"]
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
