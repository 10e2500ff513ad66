"""Compares depth that `fabkit reconstruct` computes from captures with ground truth, and reads real captures of pins.

    python check_reconstruct.py path/to/fabkit [--captures DIR --pose POSE.yaml --constants LIGHT.json]

Simulated presses come first. DIR is a folder of R-Tac0's published captures with ref.png; the pose and the light
constants are those that `calibrate extrinsics` and `fit-light` compute from them. On demand.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

PRESSES = {
    "rtac0": ["hemisphere@30deg,120deg,1.2mm", "semi-dome-017", "semi-dome-040", "semi-dome-088"],
    "9dtact": ["hemisphere@2mm,-3mm,1mm", "ball@-4mm,2mm,0.8mm"],
    "digit-like": ["ball@0mm,0mm,0.8mm", "hemisphere@-2mm,-3mm,1mm", "ball@4mm,3mm,0.4mm"],
    "gelsight-like": ["ball@0mm,0mm,0.8mm", "ball@3mm,2mm,0.5mm"],
    "shadowtac": ["ball@10deg,0deg,1mm", "ball@24deg,120deg,0.8mm", "ball@40deg,200deg,0.7mm"],
}
# Half side of the window around a pin in which its largest depth is read, px.
AROUND_PX = 6


def run(fabkit: str, *words: Any) -> dict[str, Any]:
    done = subprocess.run([fabkit, *map(str, words), "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def simulated(fabkit: str, sensor: str, folder: Path) -> None:
    """Prints the errors for simulated presses on a sensor."""
    folder.mkdir()
    run(fabkit, "capture", sensor, "--reference", "--seed", 99, "-o", folder / "ref.png")
    for seed, press in enumerate(PRESSES[sensor]):
        picture = folder / f"{seed}.png"
        run(fabkit, "capture", sensor, "--press", press, "--seed", seed, "-o", picture, "--truth", folder / f"{seed}-truth.npz")
        told = run(fabkit, "reconstruct", sensor, "--reference", folder / "ref.png", picture, "-o", folder / "out")
        truth, found = np.load(folder / f"{seed}-truth.npz"), np.load(folder / "out" / f"{seed}.npz")
        pressed = truth["contact"] & np.isfinite(found["depth_mm"])
        miss = (found["depth_mm"] - truth["indentation_mm"])[pressed]
        print(f"{sensor}, {press}: L1 {np.abs(miss).mean():.3f} mm where it presses, {100 * (np.abs(miss) < 0.1).mean():.0f} % below 0.1 mm, "
              f"mean {miss.mean():+.3f}; a constant 0 is {truth['indentation_mm'][pressed].mean():.3f} mm off; "
              f"{told['pictures_per_s']:.0f} pictures/s; simulated")


def real(fabkit: str, args: argparse.Namespace, folder: Path) -> None:
    """Prints the depth of real pins by their polar angle."""
    pictures = sorted(path for path in args.captures.glob("*.png") if path.name != "ref.png")
    reference = args.captures / "ref.png"
    run(fabkit, "reconstruct", "rtac0", "--pose", args.pose, "--constants", args.constants, "--reference", reference,
        *pictures, "-o", folder / "real")
    run(fabkit, "depth", "rtac0", "--reference", "--pose", args.pose, "-o", folder / "rest.npz")
    rest = np.load(folder / "rest.npz")
    cosine, rings = np.cos(rest["incidence_rad"]), {}
    for image in run(fabkit, "calibrate", "pins", "--reference", reference, *pictures)["images"]:
        depth = np.load(folder / "real" / f"{Path(image['file']).stem}.npz")["depth_mm"]
        for pin in image["pins"]:
            x, y = (round(value) for value in pin["pixel"])
            window = slice(max(0, y - AROUND_PX), y + AROUND_PX + 1), slice(max(0, x - AROUND_PX), x + AROUND_PX + 1)
            place = rest["point_in_sensor"][y, x]
            ring = int(np.degrees(np.arctan2(np.hypot(*place[:2]), place[2])) // 18) * 18
            rings.setdefault(ring, []).append((np.nanmax(depth[window]), np.nanmax((depth * cosine)[window])))
    for ring, depths in sorted(rings.items()):
        along_ray, along_normal = np.median(depths, axis=0)
        print(f"real pins from {ring} deg: {len(depths)}, median {along_ray:.2f} mm along the ray, {along_normal:.2f} mm along the "
              f"normal, scatter {np.std([normal for _, normal in depths]):.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fabkit")
    parser.add_argument("--captures", type=Path)
    parser.add_argument("--pose", type=Path)
    parser.add_argument("--constants", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for sensor in PRESSES:
            simulated(args.fabkit, sensor, Path(folder) / sensor)
        if args.captures:
            real(args.fabkit, args, Path(folder))


if __name__ == "__main__":
    main()
