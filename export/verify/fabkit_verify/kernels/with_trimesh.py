"""The kernel trimesh: reads the STL file that fabkit wrote, as a printer's software would."""

from __future__ import annotations

import json
from pathlib import Path

import numpy
import trimesh

from ..measured import Mass, Rebuilt, RebuildError
from . import triangles

NAME = "trimesh"

# Number of lines in one call: trimesh stores every pair of line and triangle whose boxes overlap, which is
# gigabytes for thousands of lines.
BATCH = 100


def rebuild(tree: dict, samples: dict, folder: Path) -> Rebuilt:
    """Measures the mesh in `folder/NAME.stl`, moved back to the frame of the tree's root."""
    del samples
    name = tree["name"]
    path = folder / f"{name}.stl"
    try:
        mesh = trimesh.load_mesh(path, process=False)
    except (OSError, ValueError) as error:
        raise RebuildError(f"{path.name} cannot be read: {error}") from error
    # STL stores each triangle's corners; merge equal ones into one vertex.
    mesh.merge_vertices(digits_vertex=None)
    mesh.apply_transform(numpy.linalg.inv(_file_from_part(folder, name)))
    corners = numpy.asarray(mesh.triangles)
    return Rebuilt(
        kernel=NAME,
        mass=_mass(mesh),
        bounds_mm=numpy.asarray(mesh.bounds),
        genus=_genus(mesh),
        shells=mesh.body_count,
        chord_mm=tree["mesh"]["chord_tolerance_mm"],
        crossings=lambda origins, directions: _crossings(mesh, origins, directions),
        contains=lambda points: _contains(mesh, points),
        distance_mm=triangles.Distances(corners),
        complaints=_complaints(mesh),
    )


def _file_from_part(folder: Path, name: str) -> numpy.ndarray:
    manifest = json.loads((folder / "manifest.json").read_text())
    for part in manifest["parts"]:
        if part["name"] == name:
            if part["compensation"]["scale"] != 1.0:
                raise RebuildError(f"{name}.stl is no nominal export")
            matrix = numpy.eye(4)
            matrix[:3, :3] = part["file_from_part"]["rotation"]
            matrix[:3, 3] = part["file_from_part"]["translation_mm"]
            return matrix
    raise RebuildError(f"the manifest does not list {name}")


def _complaints(mesh: trimesh.Trimesh) -> list[str]:
    found = []
    if not mesh.is_watertight:
        found.append("the mesh is not closed")
    if not mesh.is_winding_consistent:
        found.append("neighbouring triangles face different ways")
    if (mesh.area_faces <= 0).any():
        found.append("a triangle has no area")
    return found


def _mass(mesh: trimesh.Trimesh) -> Mass:
    return Mass(
        volume_mm3=float(mesh.volume),
        area_mm2=float(mesh.area),
        centroid_mm=numpy.asarray(mesh.center_mass),
        inertia_mm5=numpy.asarray(mesh.moment_inertia),
    )


def _genus(mesh: trimesh.Trimesh) -> int:
    # The Euler characteristic is 2 for a sphere, less 2 for each handle.
    return mesh.body_count - mesh.euler_number // 2


def _crossings(mesh, origins, directions) -> list[numpy.ndarray]:
    found = []
    for first in range(0, len(origins), BATCH):
        batch = slice(first, first + BATCH)
        found += _crossings_of_batch(mesh, origins[batch], directions[batch])
    return found


def _crossings_of_batch(mesh, origins, directions) -> list[numpy.ndarray]:
    # Rays start at a point: move it behind the whole mesh.
    middle = numpy.einsum("ij,ij->i", mesh.bounds.mean(0) - origins, directions)
    back = middle - mesh.scale - 1.0
    where, ray, _ = mesh.ray.intersects_location(
        origins + back[:, None] * directions, directions, multiple_hits=True
    )
    if len(ray) == 0:
        return [numpy.array([])] * len(origins)
    along = numpy.einsum("ij,ij->i", where - origins[ray], directions[ray])
    order = numpy.lexsort((along, ray))
    ray, along = ray[order], along[order]
    return [along[ray == i] for i in range(len(origins))]


def _contains(mesh, points) -> list[bool]:
    return triangles.contains(points, lambda *lines: _crossings(mesh, *lines))
