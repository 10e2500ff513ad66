"""Follows the rays of a sensor's camera with Mitsuba 3 through triangles of its bodies, and compares what they
see and where with `fabkit depth`. Then first hits of the same rays with Embree, and rates of both.

    python check_mitsuba.py path/to/fabkit [--pixels N] [SENSOR ...]

Mitsuba finds crossings and bends rays (its `dielectric`) in single precision; the triangles are as near to the
surfaces as fabkit makes them. What may differ follows from that: points by a few chord tolerances, bodies at edges:
pixels of which a neighbour sees what Mitsuba says.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from check_light import spread
from light.roots import Array
from light.solids import Rays
from light.tracing import NOTHING, SURFACE, Stack
from mitsuba_scene import CHORD_MM, Part, dictionary, export, parts

SENSORS = ["rtac0", "9dtact", "shadowtac"]
PIXELS = 20_000
MOST_PIECES = 64
# Rays begin again so far from a face, mm.
ASIDE_MM = 1e-4
# Points at grazing incidence move by more than the triangles are off.
APART_MM = 10.0 * CHORD_MM
# Shares of pixels that may be farther apart, or see another body where no neighbour does: coarse edges.
MOST_APART = 2e-3
MOST_OTHERS = 2e-4


def mitsuba() -> Any:
    """Mitsuba, one ray at a time: its vector kernels need an LLVM that fits."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    return mi


def follow(mi: Any, stack: Stack, found: list[Part], surface: list[Part], rays: Rays
           ) -> tuple[Array, Array]:
    """What rays see, as numbers in `seen_by_names`, and where."""
    scene, outside = mi.load_dict(dictionary(mi, found)), mi.load_dict(dictionary(mi, surface))
    skins = {item.name for item in stack.items if item.part == "skin"}
    seen, point = np.zeros(len(rays), int), np.full((len(rays), 3), np.nan)
    context = mi.BSDFContext()
    context.component = 1  # Transmission alone.
    for number, (o, d) in enumerate(zip(rays.o, rays.d)):
        ray, name = mi.Ray3f(o, d), NOTHING
        for _ in range(MOST_PIECES):
            hit = scene.ray_intersect(ray)
            if not hit.is_valid():
                break
            part = found[int(hit.shape.id()[4:])]
            if part.inner is None:
                name = part.name
                break
            sample, weight = hit.bsdf(ray).sample(context, hit, 0.5, mi.Point2f(0.5, 0.5))
            if max(weight) <= 0.0:
                name = len(stack.names) - 1
                break
            out = hit.to_world(sample.wo)
            # Not the same face again.
            ray = mi.Ray3f(hit.p + ASIDE_MM * out, out)
        if name in skins:
            # Straight on through skin.
            through = outside.ray_intersect(mi.Ray3f(hit.p - ASIDE_MM * ray.d, ray.d))
            if through.is_valid():
                name, point[number] = SURFACE, np.array(through.p)
        seen[number] = name
    return seen, point


def truth_of(fabkit: str, sensor: str, folder: Path) -> dict[str, Array]:
    file = folder / "map.npz"
    subprocess.run([fabkit, "depth", sensor, "--reference", "--quiet", "-o", str(file)], check=True)
    with np.load(file) as arrays:
        return {name: arrays[name] for name in ("seen_by", "point_in_sensor")}


def near(seen: Array, row: Array, column: Array, name: Array) -> Array:
    """Whether a pixel's neighbour sees this."""
    height, width = seen.shape
    result = np.zeros(len(row), bool)
    for down in (-1, 0, 1):
        for right in (-1, 0, 1):
            r, c = np.clip(row + down, 0, height - 1), np.clip(column + right, 0, width - 1)
            result |= seen[r, c] == name
    return result


def check(mi: Any, fabkit: str, sensor: str, count: int, folder: Path) -> bool:
    """One scene; says what is found."""
    stack, triangles = export(fabkit, sensor, folder / sensor)
    truth = truth_of(fabkit, sensor, folder)
    found, surface = parts(stack, triangles)
    seen, point = truth["seen_by"], truth["point_in_sensor"]
    at = spread(seen.shape[1], seen.shape[0], count)
    row, column = np.divmod(at, seen.shape[1])
    rays = stack.pixels(column.astype(float), row.astype(float))
    name, met = follow(mi, stack, found, surface, rays)
    expected = seen[row, column].astype(int)
    other = name != expected
    excused = other & near(seen, row, column, name)
    both = (name == SURFACE) & (expected == SURFACE)
    off = np.linalg.norm(met - point[row, column], axis=-1)[both]
    far = int((off > APART_MM).sum())
    print(f"check_mitsuba: {sensor}: {len(at)} pixels, {sum(len(p.corners) for p in found)} triangles "
          f"within {CHORD_MM} mm; {int(other.sum())} see another body, {int(excused.sum())} of them at "
          f"edges; points apart: median {np.median(off):.1e} mm, 99.9 % {np.quantile(off, 0.999):.1e}, "
          f"worst {off.max():.1e}; {far} by more than {APART_MM} mm")
    for k in np.flatnonzero(other & ~excused)[:5]:
        names = stack.names[expected[k]], stack.names[name[k]]
        print(f"  ({column[k]}, {row[k]}): fabkit {names[0]}, Mitsuba {names[1]}")
    few = int((other & ~excused).sum()) <= MOST_OTHERS * len(at)
    return few and far <= MOST_APART * len(at)


def rates(fabkit: str, stack: Stack, triangles: dict[str, Array], sensor: str, folder: Path) -> None:
    """First hits by Embree, whole paths by fabkit: rays per CPU second on one thread."""
    import trimesh

    found, _ = parts(stack, triangles)
    corners = np.concatenate([part.corners for part in found])
    mesh = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3),
                           process=False)
    embree = trimesh.ray.ray_pyembree.RayMeshIntersector(mesh)
    camera = stack.light["camera"]
    row, column = np.divmod(np.arange(camera["width_px"] * camera["height_px"]), camera["width_px"])
    rays = stack.pixels(column.astype(float), row.astype(float))
    embree.intersects_first(rays.o[:10], rays.d[:10])
    began = time.process_time()
    for _ in range(3):
        embree.intersects_first(rays.o, rays.d)
    embree_rate = 3 * len(rays) / (time.process_time() - began)

    def seconds(samples: int) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        subprocess.run([fabkit, "depth", sensor, "--reference", "--quiet", "--threads", "1", "--samples",
                        str(samples), "--mask", str(folder / "mask.png")], check=True)
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    # What does not depend on rays cancels.
    few, many = min(seconds(1) for _ in range(3)), min(seconds(4) for _ in range(3))
    rate = 15 * len(rays) / (many - few)
    print(f"check_mitsuba: {sensor}: fabkit follows {rate / 1e6:.2f} M rays per CPU second to their ends "
          f"(lens and mask included); Embree finds {embree_rate / 1e6:.2f} M first hits of the same rays "
          f"among {len(corners)} triangles; ratio {rate / embree_rate:.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("fabkit")
    parser.add_argument("sensors", nargs="*", default=SENSORS)
    parser.add_argument("--pixels", type=int, default=PIXELS)
    asked = parser.parse_intermixed_args()
    mi = mitsuba()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        fine = [check(mi, asked.fabkit, name, asked.pixels, folder) for name in asked.sensors]
        stack, triangles = export(asked.fabkit, "rtac0", folder / "rates")
        rates(asked.fabkit, stack, triangles, "rtac0", folder)
    if not all(fine):
        sys.exit("check_mitsuba: light goes elsewhere than fabkit says")


if __name__ == "__main__":
    main()
