"""Traces the rays of pixels through a sensor's bodies with NumPy and compares with `fabkit depth`: each ray must end on
the same body, at points within 1e-7 mm.

    python check_light.py path/to/fabkit [--sample N] [SENSOR ...]

By default it traces 50,000 pixels of each sensor, which takes minutes. A pixel may differ only if its ray passes an
edge: moved sideways by 1e-6 mm in one of 16 directions, the ray must give fabkit's result.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np

from light.roots import Array
from light.solids import Rays
from light.tracing import SURFACE, Stack

ROOT = Path(__file__).resolve().parents[2]
SENSORS = ["rtac0", "shadowtac", "uvdtact", "tactip", "9dtact"]
PIXELS = 50_000
# Largest distance of points, mm.
APART_MM = 1e-7
# Sideways displacement of rays to detect a near edge, mm.
ASIDE_MM = 1e-6
# Largest number of differing pixels in 50,000: few rays pass an edge that closely.
MOST_AT_EDGES = 5
# Rays in one batch, to limit memory.
AT_ONCE = 5_000
# Rays along each side of a pixel: TacTip's chip has only 900 pixels.
SAMPLES = {"tactip": 8}


@dataclass
class Found:
    """Result of the comparison of two tracers."""

    pixels: int
    on_surface: int
    bent: int
    apart_mm: float
    # Column and row of differing pixels, and the number of them that an edge explains.
    differ: list[tuple[float, float]]
    at_edges: int
    seconds: float

    @property
    def agrees(self) -> bool:
        return len(self.differ) == self.at_edges <= MOST_AT_EDGES


def run(fabkit: str, *arguments: Any) -> None:
    subprocess.run([fabkit, *map(str, arguments), "--quiet"], check=True)


def spread(width: int, height: int, count: int) -> Array:
    """Returns `count` different pixels spread over the image, in steps of the golden ratio."""
    total = width * height
    if count >= total:
        return np.arange(total)
    step = int(total * 0.6180339887498949) | 1
    while np.gcd(step, total) != 1:
        step += 2
    return np.sort(np.arange(count) * step % total)


def compare(stack: Stack, truth: dict[str, Any], count: int, samples: int) -> Found:
    """Traces pixels of one map and compares them with `truth`."""
    seen, point = truth["seen_by"], truth["point_in_sensor"]
    height, width = seen.shape
    at = spread(width, height, count)
    began = time.process_time()
    row, column = np.divmod(at, width)
    place = np.stack([(column + 0.5) / samples - 0.5, (row + 0.5) / samples - 0.5])
    names, points, bends = [], [], []
    for first in range(0, len(at), AT_ONCE):
        part = slice(first, first + AT_ONCE)
        paths = stack.follow(stack.pixels(*place[:, part]))
        names.append(paths.seen_by)
        points.append(paths.point)
        bends.append(paths.bends)
    name, met = np.concatenate(names), np.concatenate(points)
    expected = seen[row, column].astype(int)
    off = np.linalg.norm(met - point[row, column], axis=-1)
    both = (name == SURFACE) & (expected == SURFACE)
    differs = (name != expected) | (both & ~(off <= APART_MM))
    wrong = np.flatnonzero(differs)
    # With too many differences the check fails anyway: do not look for edges.
    asked = wrong if len(wrong) <= MOST_AT_EDGES else wrong[:0]
    edges = sum(at_edge(stack, place[:, k], expected[k], point[row[k], column[k]]) for k in asked)
    return Found(
        pixels=len(at),
        on_surface=int((expected == SURFACE).sum()),
        bent=int((np.concatenate(bends) > 0).sum()),
        apart_mm=float(off[both & ~differs].max(initial=0.0)),
        differ=[(float(place[0, k]), float(place[1, k])) for k in wrong],
        at_edges=int(edges),
        seconds=time.process_time() - began,
    )


def at_edge(stack: Stack, pixel: Array, expected: int, point: Array) -> bool:
    """Returns whether some ray slightly aside gives the expected result and another does not: an edge is between."""
    ray = stack.pixels(pixel[:1], pixel[1:])
    across = np.linalg.svd(ray.d)[2][1:]
    turn = np.arange(16) * np.pi / 8.0
    aside = ASIDE_MM * (np.cos(turn)[:, None] * across[0] + np.sin(turn)[:, None] * across[1])
    paths = stack.follow(Rays(ray.o + aside, np.repeat(ray.d, len(turn), axis=0)))
    same = paths.seen_by == expected
    if expected == SURFACE:
        # Refraction near an edge may magnify the ray's displacement, but not by more than that.
        same &= np.linalg.norm(paths.point - point, axis=-1) < 100.0 * ASIDE_MM
    return bool(same.any() and not same.all())


def is_smooth(stack: Stack) -> bool:
    """Returns whether rays in the planes of symmetry end where their neighbours do; no pixel's ray is in them."""
    of = stack.light["camera"]["parameters"]
    off = np.array([0.1, 0.2, 0.3]) * of["fx_px"]
    zero = np.zeros(3)
    column = of["cx_px"] + np.concatenate([off, zero, zero + 1e-7, off])
    row = of["cy_px"] + np.concatenate([zero, off, off, zero + 1e-7])
    paths = stack.follow(stack.pixels(column, row))
    order = [0, 1, 2, 3, 4, 5], [9, 10, 11, 6, 7, 8]
    names, points = ((of[order[0]], of[order[1]]) for of in (paths.seen_by, paths.point))
    far = np.linalg.norm(points[0] - points[1], axis=-1) > 1e-4
    return bool((names[0] == names[1]).all() and not far.any())


def spoiled(light: dict[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Returns documents with small errors, which the comparison must detect, with their descriptions."""
    wrong: list[tuple[str, dict[str, Any]]] = []

    def changed(what: str) -> dict[str, Any]:
        wrong.append((what, json.loads(json.dumps(light))))
        return wrong[-1][1]

    media = [k for k, body in enumerate(light["bodies"]) if body["part"] == "medium"]
    if media:
        body = changed("an index changed by 1e-6")["bodies"][media[-1]]
        body["refractive_index"] += 1e-6
        body = changed("a medium moved by 1e-5 mm")["bodies"][media[-1]]
        body["placements"][0]["sensor_from_body"]["translation_mm"][2] += 1e-5
    changed("a camera moved by 1e-6 mm")["camera"]["sensor_from_camera"]["translation_mm"][0] += 1e-6
    changed("another focal length")["camera"]["parameters"]["fx_px"] *= 1.0 + 1e-7
    return wrong


def check(fabkit: str, sensor: str, count: int, folder: Path) -> bool:
    """Checks one sensor and prints the result."""
    samples = SAMPLES.get(sensor, 1)
    run(fabkit, "export", sensor, "--format", "light", "-o", folder / sensor)
    run(fabkit, "depth", sensor, "--reference", "--samples", samples, "-o", folder / "map.npz")
    light = json.loads((folder / sensor / "light.json").read_text())
    schema = json.loads((ROOT / "docs/light.schema.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(light)
    with np.load(folder / "map.npz") as file:
        truth = {name: file[name] for name in ("seen_by", "seen_by_names", "point_in_sensor")}
    assert [*truth["seen_by_names"]] == light["seen_by_names"], sensor
    found = compare(Stack(light), truth, count, samples)
    print(f"check_light: {sensor}: {found.pixels} pixels, {found.on_surface} see the surface, "
          f"{found.bent} are bent; {len(found.differ)} differ, {found.at_edges} of them at edges; "
          f"points within {found.apart_mm:.1e} mm ({found.seconds:.0f} s)")
    for column, row in found.differ[:10]:
        k = int(round((row + 0.5) * samples - 0.5)), int(round((column + 0.5) * samples - 0.5))
        ours = trace_one(Stack(light), column, row)
        by = light["seen_by_names"][truth["seen_by"][k]]
        print(f"  ({column:g}, {row:g}): fabkit {by} {truth['point_in_sensor'][k]}, here {ours}")
    # The comparison counts only if it detects each deliberate error.
    fine = found.agrees and is_smooth(Stack(light))
    for what, document in spoiled(light):
        spoilt = compare(Stack(document), truth, min(count, 50), samples)
        if spoilt.agrees:
            print(f"check_light: {sensor}: {what} is not found")
            fine = False
    return fine


def trace_one(stack: Stack, column: float, row: float) -> str:
    """Describes where the ray of one pixel ends."""
    paths = stack.follow(stack.pixels(np.array([column]), np.array([row])))
    return f"{stack.names[paths.seen_by[0]]} {paths.point[0]} after {paths.bends[0]} bends"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("fabkit")
    parser.add_argument("sensors", nargs="*", default=SENSORS)
    parser.add_argument("--sample", type=int, default=PIXELS, help="pixels of each sensor")
    asked = parser.parse_intermixed_args()
    with tempfile.TemporaryDirectory() as folder:
        fine = [check(asked.fabkit, sensor, asked.sample, Path(folder)) for sensor in asked.sensors]
    if not all(fine):
        sys.exit("check_light: light goes elsewhere than fabkit says")


if __name__ == "__main__":
    main()
