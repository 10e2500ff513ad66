"""Fits a camera to the dimples in an image of a real ShadowTac, through the design's plate and gel.

    python fit_shadowtac_dimples.py DIR [--fabkit path/to/fabkit]

DIR contains `dimples_px.csv` (`x_px,y_px`: centroids of 185 dimples of the published unit at rest). Positions are
those of the design's dimples; Newton's method finds the ray to each with the tracer in `light/`. The fit changes the
camera's rotation, the image centre and the focal length. The design's lens has the model of `light.json`; its maker
publishes none, so classical projections are fitted for comparison. The script fails if the design's lens has a median
error of 3 px or more, or needs a focal length outside its tolerance.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from light.roots import Array
from light.solids import Rays
from light.tracing import Stack

BOUND_PX = 3.0
# Radius in the image over focal length, by the angle to the axis; `main` adds the design's lens.
LENSES: dict[str, Callable[[Array], Array]] = {
    "equidistant": lambda angle: angle,
    "equisolid": lambda angle: 2.0 * np.sin(0.5 * angle),
    "stereographic": lambda angle: 2.0 * np.tan(0.5 * angle),
    "rectilinear": np.tan,
}
# Point of a dimple that its centroid in the image shows, as a share of its height: half way from mouth to tip.
DEEP_SHARE = 0.5
# Largest distance of a solved ray from its point.
NEAR_MM = 1e-8
DIMPLE = re.compile(r"dimple \d+")


def dimples(tree: dict[str, Any], rotation: Array, shift: Array) -> Iterator[tuple[Array, Array]]:
    """Yields the mouth of each dimple and its unit axis out of the gel, in the frame of the root."""
    ((kind, of),) = tree.items()
    if kind == "feature" and DIMPLE.fullmatch(of["name"]):
        pose = of["of"]["placed"]["pose"]
        axis = rotation @ np.array(pose["rotation"])[:, 2]
        yield rotation @ np.array(pose["translation_mm"]) + shift, axis
    elif kind == "placed":
        by = of["pose"]
        moved = rotation @ np.array(by["translation_mm"]) + shift
        yield from dimples(of["of"], rotation @ np.array(by["rotation"]), moved)
    elif kind in ("union", "intersection"):
        for child in of:
            yield from dimples(child, rotation, shift)
    elif kind in ("feature", "difference"):
        for child in [of["of"], *of.get("minus", [])]:
            yield from dimples(child, rotation, shift)


def places(light: dict[str, Any], height_mm: float) -> Array:
    """Returns the middles of all dimples, sensor frame, mm."""
    skin = next(body for body in light["bodies"] if body["name"] == "skin")
    pose = skin["placements"][0]["sensor_from_body"]
    found = dimples(skin["solid"], np.array(pose["rotation"]), np.array(pose["translation_mm"]))
    return np.array([mouth - DEEP_SHARE * height_mm * axis for mouth, axis in found])


def looked_at(stack: Stack, pupil: Array, place: Array) -> Array:
    """Finds the unit directions at the pupil of the refracted rays through points, sensor frame."""
    straight = place - pupil
    straight /= np.linalg.norm(straight, axis=-1, keepdims=True)
    aim = straight[:, :2] / straight[:, 2:]

    def miss(aim: Array) -> Array:
        """Computes the distance of each ray from its point, at the point's height: mm along x and y."""
        d = np.concatenate([aim, np.ones((len(aim), 1))], axis=-1)
        d /= np.linalg.norm(d, axis=-1, keepdims=True)
        paths = stack.follow(Rays(np.broadcast_to(pupil, d.shape).copy(), d), clear_only=True)
        last = np.broadcast_to(pupil, d.shape).copy()
        for corner in paths.corners[1:]:
            last = np.where(np.isnan(corner), last, corner)
        way = paths.point - last
        at = last + way * ((place[:, 2] - last[:, 2]) / way[:, 2])[:, None]
        return (at - place)[:, :2]

    # One Jacobian serves all steps: it hardly changes within the first one.
    off = miss(aim)
    slopes = np.stack([(miss(aim + 1e-6 * unit) - off) / 1e-6 for unit in np.eye(2)], axis=-1)
    for _ in range(30):
        aim = aim - np.linalg.solve(slopes, off[..., None])[..., 0]
        off = miss(aim)
        if np.abs(off).max() < NEAR_MM:
            break
    assert np.abs(off).max() < NEAR_MM, "rays that do not meet their places"
    d = np.concatenate([aim, np.ones((len(aim), 1))], axis=-1)
    return d / np.linalg.norm(d, axis=-1, keepdims=True)


def pixels(d: Array, values: Array, lens: str) -> Array:
    """Projects directions through a lens: `values` are centre, focal length (px), rotation about z, then x and y (rad).
    """
    cx, cy, f, turn = values[:4]
    x, y = values[4:6] if len(values) > 4 else (0.0, 0.0)
    d = d @ np.array([[1, 0, 0], [0, np.cos(x), np.sin(x)], [0, -np.sin(x), np.cos(x)]])
    d = d @ np.array([[np.cos(y), 0, -np.sin(y)], [0, 1, 0], [np.sin(y), 0, np.cos(y)]])
    out = np.hypot(d[:, 0], d[:, 1])
    r = f * LENSES[lens](np.arctan2(out, d[:, 2]))
    angle = np.arctan2(d[:, 1], d[:, 0]) + turn
    return np.stack([cx + r * np.cos(angle), cy + r * np.sin(angle)], axis=-1)


def matched(seen: Array, drawn: Array) -> Array:
    """Returns the index of the nearest projected dimple for each centroid."""
    return np.linalg.norm(seen[:, None] - drawn[None], axis=-1).argmin(1)


def first_guess(seen: Array, d: Array, lens: str) -> Array:
    """Searches a first guess of centre, focal length and rotation about z.

    The focal length follows from the pitch of dimples near the axis; every centroid near the middle is tried as
    the centre, with rotations in steps of 1 degree.
    """
    gaps = np.linalg.norm(seen[:, None] - seen[None], axis=-1) + 1e9 * np.eye(len(seen))
    angles = np.sort(np.arctan2(np.hypot(d[:, 0], d[:, 1]), d[:, 2]))
    f = np.median(gaps.min(1)) / np.median(angles[1:7])
    middle = seen.mean(0)
    near = np.argsort(np.linalg.norm(seen - middle, axis=-1))[:12]
    best: tuple[float, Array] = (np.inf, np.zeros(4))
    for number in near:
        for turn in np.radians(np.arange(0.0, 60.0, 1.0)):
            values = np.array([*seen[number], f, turn])
            off = seen - pixels(d, values, lens)[matched(seen, pixels(d, values, lens))]
            cost = float(np.median(np.linalg.norm(off, axis=-1)))
            best = min(best, (cost, values), key=lambda entry: entry[0])
    return best[1]


def fitted(seen: Array, d: Array, values: Array, lens: str) -> tuple[Array, Array, Array]:
    """Fits `values` by the Gauss-Newton method; each centroid belongs to the nearest dimple.

    Returns the values, the errors in px, and the index of each centroid's dimple.
    """
    for _ in range(30):
        number = matched(seen, pixels(d, values, lens))
        off = (pixels(d, values, lens)[number] - seen).ravel()
        steps = 1e-6 * np.maximum(np.abs(values), 1.0)
        slopes = [((pixels(d, values + s, lens)[number] - seen).ravel() - off) / s.sum()
                  for s in np.diag(steps)]
        values = values - np.linalg.lstsq(np.stack(slopes, axis=-1), off, rcond=None)[0]
    number = matched(seen, pixels(d, values, lens))
    return values, np.linalg.norm(pixels(d, values, lens)[number] - seen, axis=-1), number


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--fabkit", default="fabkit")
    parser.add_argument("--set", action="append", default=[], help="as for fabkit")
    parser.add_argument("--pupil", type=float, action="append", default=[],
                        help="move the pupil by so many mm along z too")
    asked = parser.parse_intermixed_args()
    seen = np.loadtxt(asked.folder / "dimples_px.csv", delimiter=",", skiprows=1)
    with tempfile.TemporaryDirectory() as folder:
        command = [asked.fabkit, "export", "shadowtac", "--format=light", "--part=plate", "--quiet",
                   "-o", folder, *(f"--set={value}" for value in asked.set)]
        subprocess.run(command, check=True)
        light = json.loads((Path(folder) / "light.json").read_text())
        manifest = json.loads((Path(folder) / "manifest.json").read_text())
    settings = {entry["path"]: entry["value"] for entry in manifest["parameters"]}
    height_mm = float(str(settings["dimples.height"]).split()[0])
    stack, place = Stack(light), places(light, height_mm)
    pupil = np.array(light["camera"]["sensor_from_camera"]["translation_mm"])
    lens_says = light["camera"]["parameters"]
    drawn_px, terms = lens_says["fx_px"], [lens_says[name] for name in ("k1", "k2", "k3", "k4")]
    LENSES["drawn"] = lambda angle: angle * (1.0 + sum(k * angle ** (2 * n + 2) for n, k in enumerate(terms)))
    tolerance = float(str(settings["camera.focal_tolerance"]))

    def report(what: str, d: Array, lens: str) -> tuple[float, float]:
        upright, _, _ = fitted(seen, d, first_guess(seen, d, lens), lens)
        values, errors, number = fitted(seen, d, np.append(upright, [0.0, 0.0]), lens)
        median, rms = float(np.median(errors)), float(np.sqrt((errors**2).mean()))
        twice = len(seen) - len(set(number.tolist()))
        tilt = np.degrees(values[4:6])
        print(f"{what}{lens}: median {median:.2f} px, rms {rms:.2f}, worst {errors.max():.2f}; "
              f"f {values[2]:.1f} px, centre {values[0]:.1f}, {values[1]:.1f}, turned "
              f"{np.degrees(values[3]):.2f} deg, tilted {tilt[0]:.2f}, {tilt[1]:.2f} deg"
              + (f"; {twice} matched twice" if twice else ""))
        return median, float(values[2])

    print(f"{len(seen)} dimples of {len(place)} drawn; the drawn lens has f {drawn_px:.1f} px to within {tolerance:.0%}, "
          f"k {', '.join(f'{k:.5f}' for k in terms)}")
    d = looked_at(stack, pupil, place)
    found = {lens: report("", d, lens) for lens in LENSES}
    straight = place - pupil
    straight /= np.linalg.norm(straight, axis=-1, keepdims=True)
    report("if nothing bent light, ", straight, "drawn")
    for by_mm in asked.pupil:
        moved = pupil + [0.0, 0.0, by_mm]
        moved_d = looked_at(stack, moved, place)
        for lens in LENSES:
            report(f"pupil {by_mm:+g} mm along z, ", moved_d, lens)
    median, focal_px = found["drawn"]
    off = focal_px / drawn_px - 1.0
    best = min(found, key=lambda lens: found[lens][0])
    print(f"median error: {median:.2f} px as drawn, bound {BOUND_PX} px; focal length {off:+.1%} from the drawn one; "
          f"least with the lens {best}: {found[best][0]:.2f} px")
    if not median < BOUND_PX:
        sys.exit("the drawn stack does not explain the picture")
    if abs(off) > tolerance:
        sys.exit(f"the drawn stack explains the picture with another focal length alone: {focal_px:.1f} px")


if __name__ == "__main__":
    main()
