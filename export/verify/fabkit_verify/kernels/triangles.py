"""Closed triangle meshes: integrals, containment and distances."""

from __future__ import annotations

import numpy

from ..measured import Mass

# Three unit directions at irregular angles, so that lines along them rarely lie in a design's faces.
ASKEW = numpy.array([[0.362, 0.481, 0.797], [-0.738, 0.269, 0.619], [0.213, -0.851, 0.479]])
ASKEW /= numpy.linalg.norm(ASKEW, axis=1)[:, None]


def mass(corners: numpy.ndarray) -> Mass:
    """Integrates a mesh, n x 3 x 3 corners, counter-clockwise from outside, as a sum of tetrahedra."""
    origin = corners[0, 0]
    a, b, c = (corners[:, i] - origin for i in range(3))
    normal = numpy.cross(b - a, c - a)
    determinant = numpy.einsum("ij,ij->i", a, numpy.cross(b, c))
    volume = determinant.sum() / 6.0
    total = a + b + c
    centroid = (determinant[:, None] * total).sum(0) / 24.0 / volume
    second = sum(numpy.einsum("n,ni,nj->ij", determinant, v, v) for v in (a, b, c, total)) / 120.0
    spread = second - volume * numpy.outer(centroid, centroid)
    return Mass(
        volume_mm3=float(volume),
        area_mm2=float(numpy.linalg.norm(normal, axis=1).sum() / 2.0),
        centroid_mm=centroid + origin,
        inertia_mm5=numpy.eye(3) * numpy.trace(spread) - spread,
    )


def contains(points: numpy.ndarray, crossings) -> list[bool]:
    """Returns for each point whether it is inside, by the parity of crossings of lines from it.

    A line through an edge may cross one of its faces or both, regardless of whether it enters the solid
    there. So three lines vote.
    """
    inside = numpy.zeros(len(points), int)
    for direction in ASKEW:
        lines = crossings(points, numpy.tile(direction, (len(points), 1)))
        inside += [int((numpy.asarray(hits) > 0).sum()) % 2 for hits in lines]
    return [bool(votes > len(ASKEW) // 2) for votes in inside]


class Distances:
    """Computes distances of points from triangles, n x 3 x 3."""

    def __init__(self, corners: numpy.ndarray):
        self.corners = corners
        self.centres = corners.mean(1)
        self.radii = numpy.linalg.norm(corners - self.centres[:, None], axis=2).max(1)

    def __call__(self, point: numpy.ndarray) -> float:
        """Computes the distance from a point to the nearest triangle."""
        to_centres = numpy.linalg.norm(self.centres - point, axis=1)
        # Upper bound by bounding spheres: triangles beyond it cannot be nearest.
        enough = (to_centres + self.radii).min()
        return _distance(self.corners[to_centres - self.radii <= enough], point)


def _distance(corners: numpy.ndarray, point: numpy.ndarray) -> float:
    """Computes the distance from a point to the nearest of some triangles.

    If the point's foot is inside a triangle, that is the distance to its plane, else to its nearest edge.
    """
    a, b, c = (corners[:, i] for i in range(3))
    normal = numpy.cross(b - a, c - a)
    squared = numpy.einsum("ij,ij->i", normal, normal)
    squared = numpy.where(squared > 0, squared, numpy.inf)
    within = numpy.ones(len(corners), bool)
    nearest = numpy.inf
    for start, end in ((a, b), (b, c), (c, a)):
        edge, to_point = end - start, point - start
        within &= numpy.einsum("ij,ij->i", numpy.cross(edge, to_point), normal) >= 0
        length = numpy.maximum(numpy.einsum("ij,ij->i", edge, edge), 1e-300)
        along = numpy.clip(numpy.einsum("ij,ij->i", to_point, edge) / length, 0, 1)
        nearest = min(nearest, numpy.linalg.norm(to_point - along[:, None] * edge, axis=1).min())
    heights = numpy.abs(numpy.einsum("ij,ij->i", point - a, normal)) / numpy.sqrt(squared)
    return float(min(nearest, heights[within].min(initial=numpy.inf)))
