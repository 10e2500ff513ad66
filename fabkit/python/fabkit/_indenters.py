"""Indenters with exact shapes, for :mod:`fabkit.sim`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fabkit import _arrays
from fabkit.errors import invalid

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, eq=False)
class Body:
    """An indenter with an exact shape; its origin is its centre, its axis is z."""

    kind: str
    """``ball``, ``cylinder``, ``box``, ``capsule`` or ``convex``."""
    sizes_mm: tuple[float, ...]
    """Arguments of the function that creates this kind; for ``convex`` box, points and normals."""
    sensor_from_body: NDArray[np.float64]
    """Pose: body frame to sensor frame, (4, 4), mm."""

    def placed(self, sensor_from_body: ArrayLike) -> Body:
        """Return the body at another pose, (4, 4), mm."""
        pose = np.array(_arrays.matrix(sensor_from_body, 4, "sensor_from_body"))
        return replace(self, sensor_from_body=pose)

    def at(self, x_mm: float, y_mm: float, z_mm: float) -> Body:
        """Return the body with its centre at another point of the sensor frame, not rotated."""
        pose: NDArray[np.float64] = np.array(self.sensor_from_body, dtype=np.float64)
        pose[:3, 3] = x_mm, y_mm, z_mm
        return replace(self, sensor_from_body=pose)


def ball(radius_mm: float) -> Body:
    """Create a ball."""
    return Body("ball", (float(radius_mm),), np.eye(4))


def cylinder(radius_mm: float, height_mm: float) -> Body:
    """Create a cylinder around z."""
    return Body("cylinder", (float(radius_mm), float(height_mm)), np.eye(4))


def box(x_mm: float, y_mm: float, z_mm: float) -> Body:
    """Create a box from the lengths of its edges."""
    return Body("box", (float(x_mm), float(y_mm), float(z_mm)), np.eye(4))


def capsule(radius_mm: float, height_mm: float) -> Body:
    """Create a capsule around z: a cylinder of ``height_mm`` between two hemispheres."""
    return Body("capsule", (float(radius_mm), float(height_mm)), np.eye(4))


def convex(vertices_mm: ArrayLike, triangles: ArrayLike) -> Body:
    """Create a convex body from a mesh: the intersection of the half spaces of its triangles.

    For a shape with hollows, press several convex bodies at once.

    Parameters
    ----------
    vertices_mm
        Vertices, (n, 3), mm.
    triangles
        Vertex indices, (m, 3), counter-clockwise seen from outside, as in :class:`fabkit.Mesh`.

    Raises
    ------
    FabkitError
        The mesh is not convex, or is turned inside out.
    """
    points, shape = _arrays.rows(vertices_mm, 3, "vertices_mm")
    corners = np.asarray(triangles)
    if len(shape) != 1 or corners.ndim != 2 or corners.shape[1] != 3 or not len(corners):
        raise invalid("a convex body needs vertices (n, 3) and triangles (m, 3)")
    if corners.dtype.kind not in "iu" or corners.min() < 0 or corners.max() >= len(points):
        raise invalid(f"triangles must hold indices of the {len(points)} vertices")
    first, second, third = (points[corners[:, k]] for k in range(3))
    normals = np.cross(second - first, third - first)
    areas = np.linalg.norm(normals, axis=1)
    size_mm = float(np.ptp(points, axis=0).max())
    solid = areas > 1e-9 * size_mm**2
    normals = normals[solid] / areas[solid, None]
    # Triangles of one face share a plane: keep one of them. No vertex may lie in front of a plane.
    offsets = np.einsum("ij,ij->i", normals, first[solid])
    planes = np.round(np.column_stack([normals, offsets / max(size_mm, 1e-300)]), 9)
    _, kept = np.unique(planes, axis=0, return_index=True)
    kept.sort()
    normals, offsets = normals[kept], offsets[kept]
    beyond_mm = float((points @ normals.T - offsets).max()) if len(kept) else np.inf
    if beyond_mm > 1e-6 * size_mm:
        hint = "split it into convex pieces, and press all of them; or turn its triangles around"
        raise invalid(f"the mesh is not convex: a vertex lies {beyond_mm:.3g} mm outside", hint)
    margin = 0.01 * size_mm
    faces = np.column_stack([normals * offsets[:, None], normals])
    around = [*(points.min(axis=0) - margin), *(points.max(axis=0) + margin)]
    return Body("convex", (*map(float, around), *map(float, faces.ravel())), np.eye(4))
