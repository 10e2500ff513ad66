"""Compares markers that `fabkit reconstruct` tracks in simulated captures with their true positions.

    python check_followed.py path/to/fabkit [SENSOR ...] [--unit SEED]

Captures have noise. They show the nominal sensor, or another unit of it with another camera pose; markers are always
searched through the nominal camera. On demand: captures of UVDtact and ShadowTac take minutes.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

# Shear of a press without tangential motion.
STILL = "0mm,0mm"
# Friction where the design states none: the paper's value, dry.
FRICTION = {"shadowtac": ["--friction", "0.35"]}
# For each case: light, options of `capture`, and presses with their shear.
PRESSES = {
    "tactip": ("white", ["--samples=8"], [
        ("disc-107@0deg,0deg,1mm", STILL),
        ("disc-107@15deg,60deg,2mm", STILL),
        ("disc-107@10deg,200deg,2mm", STILL),
    ]),
    "uvdtact": ("uv", [], [
        ("hemisphere@20deg,60deg,1mm", STILL),
        ("hemisphere@40deg,150deg,1mm", "0.8mm,0.3mm"),
        ("hemisphere@60deg,250deg,1.2mm", "0mm,0.8mm"),
    ]),
    "shadowtac": ("colored", [], [
        ("ball@10deg,60deg,2mm", STILL),
        ("ball@3deg,0deg,1.5mm", "1mm,0.5mm"),
    ]),
    "gelsight-like": ("colored", [], [
        ("ball@2mm,1mm,0.6mm", STILL),
        ("ball@-2mm,1mm,0.6mm", "0.5mm,0.2mm"),
    ]),
    "fluidic": ("white", ["--spacing=2mm"], [
        ("hemisphere@20mm,3mm,5mm", ""),
        ("ball@-10mm,-10mm,4mm", ""),
    ]),
    "fluidic display": ("display", ["--spacing=2mm"], [
        ("hemisphere@20mm,3mm,5mm", ""),
        ("ball@-10mm,-10mm,4mm", ""),
    ]),
}  # fmt: skip


def run(fabkit: str, *words: Any) -> dict[str, Any]:
    done = subprocess.run([fabkit, *map(str, words), "--json"], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def pixels(document: dict[str, Any]) -> np.ndarray:
    return np.array([mark["pixel"] or [np.nan, np.nan] for mark in document["marks"]], dtype=float)


def nearest(places: np.ndarray, marks: np.ndarray) -> np.ndarray:
    away = np.linalg.norm(places[:, None] - marks[None], axis=2)
    return np.where(np.isnan(away), np.inf, away).argmin(axis=1)


def judge(fabkit: str, case: str, unit: list[str], folder: Path) -> None:
    sensor = case.split()[0]
    light, more, presses = PRESSES[case]
    lit = [sensor, "--light", light]
    rest_png = folder / "rest.png"
    drawn = run(fabkit, "capture", *lit, *more, *unit, "--reference", "--seed", 1, "-o", rest_png)
    at_rest, files, truths = pixels(drawn), [], []
    for seed, (press, shear) in enumerate(presses):
        files.append(folder / f"{seed}.png")
        along = ["--shear", shear, *FRICTION.get(sensor, [])] if shear not in ("", STILL) else []
        truth = run(fabkit, "capture", *lit, *more, *unit, "--press", press, *along, "--seed", 2 + seed, "-o", files[-1])
        truths.append(pixels(truth))
    told = run(fabkit, "reconstruct", *lit, "--reference", rest_png, *files, "-o", folder / "out")
    right = seen = there = 0
    errors, moves, named = [], [], True
    for file, truth in zip(files, truths, strict=True):
        found = np.load(folder / "out" / f"{file.stem}.npz")
        rest, now, is_seen = (found[name] for name in ("mark_rest_px", "mark_px", "mark_seen"))
        known = np.isfinite(rest[:, 0])
        named &= bool((nearest(rest[known], at_rest) == np.flatnonzero(known)).all())
        # The visible part of a marker may be beside its nominal pixel, by the same offset in all images.
        in_view = known & np.isfinite(truth[:, 0])
        # A marker whose end has just left the image has no true pixel to compare with.
        is_seen &= in_view
        own = nearest(now[is_seen], truth + np.nan_to_num(rest - at_rest)) == np.flatnonzero(is_seen)
        right, seen, there = right + own.sum(), seen + is_seen.sum(), there + in_view.sum()
        moved = truth - at_rest
        errors.append(np.linalg.norm(found["mark_moved_px"] - moved, axis=1)[is_seen])
        moves.append(np.linalg.norm(moved, axis=1)[is_seen])
    error = np.concatenate(errors)
    print(f"{case}{' ' + ' '.join(unit) if unit else ''}: {told['marks']['at_rest']} of {told['marks']['in_view']} drawn in view "
          f"found at rest, {'all' if named else 'NOT all'} by their own names; of {there} then {seen} seen, "
          f"{100 * right / seen:.1f} % rightly named; moved up to {np.concatenate(moves).max():.1f} px, "
          f"off by {np.median(error):.2f} px, 95 % by less than {np.percentile(error, 95):.2f} px; "
          f"{told['marks']['pictures_per_s']:.0f} pictures/s; simulated", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("fabkit")
    parser.add_argument("cases", nargs="*", default=list(PRESSES))
    parser.add_argument("--unit", help="another unit of the same design, by its number")
    args = parser.parse_args()
    unit = ["--unit", args.unit] if args.unit else []
    for case in args.cases:
        with tempfile.TemporaryDirectory() as folder:
            judge(args.fabkit, case, unit, Path(folder))


if __name__ == "__main__":
    main()
