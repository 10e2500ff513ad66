"""Containment of points is correct even if a line from a point passes through an edge of the mesh."""

from __future__ import annotations

import unittest
from pathlib import Path

import numpy
import trimesh
from manifold3d import Manifold

from fabkit_verify.kernels import triangles, with_manifold3d, with_trimesh

# One of the directions along which kernels count crossings.
ASKEW = triangles.ASKEW[0]


def at(cuboid: list[float], corner: list[float]) -> dict:
    """Returns a cuboid from its lower corner; in trees, cuboids stand on z = 0 around the axis."""
    shift = [c + s / 2 for c, s in zip(corner, cuboid)][:2] + [corner[2]]
    pose = {"rotation": numpy.eye(3).tolist(), "translation_mm": shift}
    return {"placed": {"of": {"cuboid": {"size_mm": cuboid}}, "pose": pose}}


# A step: below z = 0 all of |x|, |y| < 2, above it the half of x > 0. Its inner edge is x = z = 0.
STEP = {"union": [at([4.0, 4.0, 2.0], [-2.0, -2.0, -2.0]), at([2.0, 4.0, 3.0], [0.0, -2.0, -1.0])]}


def places() -> tuple[numpy.ndarray, list[bool]]:
    """Returns points whose oblique line meets the inner edge, an outer edge or none, and whether each is inside."""
    inner = numpy.array([[0.0, y, 0.0] for y in (-1.1, -0.3, 0.4)])
    outer = numpy.array([[2.0, 2.0, z] for z in (-1.2, 0.3, 1.1)])
    points = [inner - 0.9 * ASKEW, outer - 0.9 * ASKEW, outer + 0.9 * ASKEW]
    below = inner - 3.0 * ASKEW
    return numpy.concatenate([*points, below]), [True] * 6 + [False] * 6


class InsideOutside(unittest.TestCase):
    def test_trimesh(self):
        manifold = with_manifold3d.build(STEP, with_manifold3d.Manifold3d())
        self.assertIsInstance(manifold, Manifold)
        mesh = manifold.to_mesh64()
        mesh = trimesh.Trimesh(numpy.asarray(mesh.vert_properties)[:, :3], mesh.tri_verts)
        points, expected = places()
        self.assertEqual([bool(x) for x in with_trimesh._contains(mesh, points)], expected)

    def test_manifold3d(self):
        rebuilt = with_manifold3d.rebuild({"solid": STEP}, {}, Path())
        points, expected = places()
        self.assertEqual([bool(x) for x in rebuilt.contains(points)], expected)


if __name__ == "__main__":
    unittest.main()
