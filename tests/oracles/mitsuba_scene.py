"""Conversion of a sensor to a scene of Mitsuba 3: triangles of fabkit's STL files at the poses of `light.json`.

Where two media touch, each has its own face; Mitsuba needs a single face with both indices. A medium's triangle on an
opaque body is left out, and of two touching media the first one keeps the face.
"""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from light.roots import Array
from light.solids import FACES, Node, Rays
from light.tracing import FIRST_BODY, Item, Stack

# Chord tolerance of the meshes, mm: the finest that fabkit makes.
CHORD_MM = 5e-4
# Distance from a triangle at which the body that it touches is searched, mm.
ASIDE_MM = 4.0 * CHORD_MM

STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])


@dataclass
class Part:
    """Triangles (n, 3, 3) of one face with the exact normals at their corners.

    Faces between media have two refractive indices, other bodies have none.
    """

    corners: Array
    normals: Array
    inner: float | None
    outer: float | None
    name: int


def export(fabkit: str, sensor: str, folder: Path) -> tuple[Stack, dict[str, Array]]:
    """Exports a sensor; returns its optical model, and the triangles of all bodies in their own frames."""
    command = [fabkit, "export", sensor, "--quiet", "--nominal", "-o", str(folder)]
    subprocess.run([*command, "--format=light"], check=True)
    light = json.loads((folder / "light.json").read_text())
    names = [body["name"] for body in light["bodies"]]
    more = [f"--part={name}" for name in names]
    tolerance = f"--tolerance={CHORD_MM}mm"
    subprocess.run([*command, "--format=stl", "--force", tolerance, *more], check=True)
    manifest = json.loads((folder / "manifest.json").read_text())
    triangles: dict[str, Array] = {}
    for part in manifest["parts"]:
        corners = np.fromfile(folder / f"{part['name']}.stl", STL, offset=84)["corners"]
        pose = part["file_from_part"]
        moved = corners.astype(float) - np.array(pose["translation_mm"])
        triangles[part["name"]] = moved @ np.array(pose["rotation"])
    return Stack(light), triangles


def holds(node: Node, points: Array) -> Array:
    """Returns for each point whether it is inside a solid."""
    result = np.zeros(len(points), bool)
    # An oblique unit direction that is parallel to no face.
    d = np.array([0.48, 0.36, 0.8])
    spans = node.spans(Rays(points, np.broadcast_to(d, points.shape)))
    result[spans.ray[(spans.low < 0.0) & (spans.high > 0.0)]] = True
    return result


def exact_normals(stack: Stack, node: Node, corners: Array, flat: Array) -> Array:
    """Computes the normals of the exact faces at the corners; the triangle's own where no face is near."""
    middle = corners.mean(1, keepdims=True)
    # Move the corners slightly inwards, away from edges.
    points = (corners + 1e-3 * (middle - corners)).reshape(-1, 3)
    result = np.repeat(flat, 3, axis=0)
    d = result.copy()
    start = points - ASIDE_MM * 4.0 * d
    spans = node.spans(Rays(start, d))
    for end, code in ((spans.low, spans.face_low), (spans.high, spans.face_high)):
        near = np.abs(end - 4.0 * ASIDE_MM) < ASIDE_MM
        ray = spans.ray[near]
        at = start[ray] + end[near][:, None] * d[ray]
        normal = stack.forest.normals(at, code[near] // FACES * FACES + code[near] % FACES)
        same = np.sign((normal * d[ray]).sum(-1, keepdims=True))
        result[ray] = normal * same
    return result.reshape(-1, 3, 3)


def parts(stack: Stack, triangles: dict[str, Array]) -> tuple[list[Part], list[Part]]:
    """Returns all faces that stop or refract rays, and those of the sensing surface alone."""
    found: list[Part] = []
    surface: list[Part] = []
    placed = [(body, place) for body in stack.light["bodies"] for place in body["placements"]
              if not place["is_cameras_own"]]
    for number, ((body, place), item) in enumerate(zip(placed, stack.items)):
        pose = place["sensor_from_body"]
        corners = triangles[body["name"]] @ np.array(pose["rotation"]).T + pose["translation_mm"]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        size = np.linalg.norm(flat, axis=-1, keepdims=True)
        real = size[:, 0] > 0.0
        corners, flat = corners[real], flat[real] / size[real]
        if item.part == "medium":
            found += _faces(stack, number, corners, flat)
        else:
            found.append(Part(corners, np.repeat(flat[:, None], 3, 1), None, None, item.name))
        if item.is_skin and stack.surface:
            at = _on_surface(stack.surface, corners, flat)
            part = Part(corners[at], np.repeat(flat[at, None], 3, 1), None, None, item.name)
            surface.append(part)
    found, surface = ([p for p in some if len(p.corners)] for some in (found, surface))
    return found, surface


def _faces(stack: Stack, number: int, corners: Array, flat: Array) -> list[Part]:
    item = stack.items[number]
    outside = corners.mean(1) + ASIDE_MM * flat
    outer = np.full(len(corners), 1.0)
    for other, touched in enumerate(stack.items):
        if other == number:
            continue
        at = holds(touched.node, outside)
        is_its = touched.part != "medium" or touched.index == item.index or other < number
        outer[at] = np.nan if is_its else touched.index
    found = []
    for index in np.unique(outer[~np.isnan(outer)]):
        at = outer == index
        normals = exact_normals(stack, item.node, corners[at], flat[at])
        found.append(Part(corners[at], normals, item.index, float(index), item.name))
    return found


def _on_surface(surface: Node, corners: Array, flat: Array) -> Array:
    """Returns the indices of the triangles that lie on the boundary of the sensing surface's solid."""
    middle = corners.mean(1)
    ends = holds(surface, middle - ASIDE_MM * flat) & ~holds(surface, middle + ASIDE_MM * flat)
    return np.flatnonzero(ends)


def dictionary(mi: Any, found: list[Part]) -> dict[str, Any]:
    """Creates the dictionary for `mi.load_dict`; shapes are numbered in the order of the parts."""
    scene: dict[str, Any] = {"type": "scene"}
    for number, part in enumerate(found):
        properties = mi.Properties()
        if part.inner is None:
            bsdf = {"type": "diffuse"}
        else:
            bsdf = {"type": "dielectric", "int_ior": part.inner, "ext_ior": part.outer}
        properties["bsdf"] = mi.load_dict({"type": "twosided", "b": bsdf}
                                          if part.inner is None else bsdf)
        count = len(part.corners)
        mesh = mi.Mesh(f"part{number:03}", 3 * count, count, props=properties,
                       has_vertex_normals=True)
        values = mi.traverse(mesh)
        values["vertex_positions"] = part.corners.astype(np.float32).ravel()
        values["vertex_normals"] = part.normals.astype(np.float32).ravel()
        values["faces"] = np.arange(3 * count, dtype=np.uint32)
        values.update()
        scene[f"part{number:03}"] = mesh
    return scene


def word(stack: Stack, name: int) -> str:
    """Returns the name of a body by its number."""
    return stack.names[name]


__all__ = ["CHORD_MM", "FIRST_BODY", "Item", "Part", "dictionary", "export", "parts", "word"]
