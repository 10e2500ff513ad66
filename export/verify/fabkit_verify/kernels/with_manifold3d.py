"""The kernel manifold3d, which works with triangles.

Its own spheres and circles have no chord tolerance, so every round body is built as a revolved or
extruded polygon whose corners lie on the exact curve.
"""

from __future__ import annotations

import math

import numpy
from manifold3d import CrossSection, Error, FillRule, Manifold, Mesh64, OpType

from ..curves import polyline, steps_of_turn
from ..measured import Rebuilt, RebuildError
from ..walk import build, profile_reach_mm
from . import triangles

NAME = "manifold3d"

# Largest distance of a triangle from the exact surface, mm. If a face is curved in two directions, each
# gets half of it.
CHORD_MM = 0.01

# Decimal places, in mm, to which corners are rounded: far below the chord, and above the steps of 1e-8 in
# which cross-sections are stored.
SNAP_DIGITS = 7


class Manifold3d:
    """Builds meshes from revolved and extruded polygons."""

    def sphere(self, radius_mm):
        return self._turned(_half_ellipse(radius_mm, radius_mm, 0.0), radius_mm)

    def ellipsoid(self, semi_axes_mm):
        # Start with a sphere of the longest half axis: scaling by at most 1 does not increase chord errors.
        longest = max(semi_axes_mm)
        unit = self.sphere(longest)
        return unit.scale([axis / longest for axis in semi_axes_mm])

    def cylinder(self, radius_mm, height_mm):
        return self.cone(radius_mm, radius_mm, height_mm)

    def cone(self, bottom_radius_mm, top_radius_mm, height_mm):
        outline = [(0, 0), (bottom_radius_mm, 0), (top_radius_mm, height_mm), (0, height_mm)]
        # A cone with an apex has one point there, not two equal ones.
        outline = [p for i, p in enumerate(outline) if p != outline[i - 1]]
        return self._turned(outline, max(bottom_radius_mm, top_radius_mm))

    def cuboid(self, size_mm):
        x, y, z = size_mm
        return Manifold.cube((x, y, z)).translate((-x / 2, -y / 2, 0))

    def torus(self, ring_radius_mm, tube_radius_mm):
        steps = steps_of_turn(math.tau, tube_radius_mm, CHORD_MM / 2)
        tube = [_on_circle(ring_radius_mm, tube_radius_mm, i / steps) for i in range(steps)]
        return self._turned(tube, ring_radius_mm + tube_radius_mm)

    def extrusion(self, profile, height_mm):
        return Manifold.extrude(_section(profile, CHORD_MM), height_mm)

    def revolution(self, profile):
        return self._revolved(_section(profile, CHORD_MM / 2), profile_reach_mm(profile))

    def ellipsoid_offset(self, equatorial_mm, polar_mm, offset_mm):
        outline = _half_ellipse(equatorial_mm, polar_mm, offset_mm)
        return self._turned(outline, equatorial_mm + offset_mm)

    def half_space(self, reach_mm):
        return self.cuboid([2 * reach_mm] * 3).translate((0, 0, -2 * reach_mm))

    def union(self, shapes):
        return Manifold.batch_boolean(_snapped(shapes), OpType.Add)

    def intersection(self, shapes):
        return Manifold.batch_boolean(_snapped(shapes), OpType.Intersect)

    def difference(self, shape, tools):
        return Manifold.batch_boolean(_snapped([shape, *tools]), OpType.Subtract)

    def placed(self, shape, pose):
        rows = [[*row, t] for row, t in zip(pose["rotation"], pose["translation_mm"])]
        return shape.transform(rows)

    def _turned(self, outline, widest_mm):
        return self._revolved(CrossSection([outline], FillRule.Positive), widest_mm)

    def _revolved(self, section, widest_mm):
        return Manifold.revolve(section, steps_of_turn(math.tau, widest_mm, CHORD_MM / 2))


def _snapped(shapes: list[Manifold]) -> list[Manifold]:
    """Rounds corners, so that faces that should meet do so exactly: otherwise a film as thin as the rounding
    remains between two cuts."""
    return [shape.warp_batch(lambda corners: corners.round(SNAP_DIGITS)) for shape in shapes]


def _on_circle(centre: float, radius: float, fraction: float) -> tuple[float, float]:
    return (
        centre + radius * math.cos(math.tau * fraction),
        radius * math.sin(math.tau * fraction),
    )


def _half_ellipse(across: float, along: float, offset: float) -> list[tuple[float, float]]:
    """Approximates a parallel curve of a half ellipse, from the lower to the upper pole."""
    longest = max(across, along)
    # The largest radius of curvature of the ellipse plus the offset: no part of the curve needs more steps.
    steps = 2 * steps_of_turn(math.pi, longest**2 / min(across, along) + abs(offset), CHORD_MM / 2)
    points = []
    for i in range(steps + 1):
        angle = math.pi * (i / steps - 0.5)
        cos, sin = math.cos(angle), math.sin(angle)
        normal = math.hypot(along * cos, across * sin)
        x = across * cos + offset * along * cos / normal
        points.append((x if 0 < i < steps else 0.0, along * sin + offset * across * sin / normal))
    return points


def _section(profile, chord_mm) -> CrossSection:
    outer = CrossSection([polyline(profile["outer"], chord_mm)], FillRule.NonZero)
    holes = [
        CrossSection([polyline(hole, chord_mm)], FillRule.NonZero)
        for hole in profile.get("holes", [])
    ]
    return CrossSection.batch_boolean([outer, *holes], OpType.Subtract) if holes else outer


def rebuild(tree: dict, samples: dict, folder: object) -> Rebuilt:
    """Builds the solid of a tree document as a mesh and measures it."""
    del samples, folder
    manifold = build(tree["solid"], Manifold3d())
    if manifold.status() != Error.NoError or manifold.is_empty():
        raise RebuildError(f"{NAME} leaves no solid ({manifold.status().name})")
    mesh: Mesh64 = manifold.to_mesh64()
    vertices = numpy.asarray(mesh.vert_properties)[:, :3]
    corners = vertices[numpy.asarray(mesh.tri_verts)]
    low, high = vertices.min(0), vertices.max(0)
    reach = float(numpy.linalg.norm(high - low)) + 1.0

    def crossing(origin, direction):
        # A segment that starts and ends outside the box.
        middle = float((0.5 * (low + high) - origin) @ direction)
        start, end = (origin + (middle + side * reach) * direction for side in (-1, 1))
        hits = manifold.ray_cast(tuple(start), tuple(end))
        return numpy.sort([middle - reach + 2 * reach * hit.distance for hit in hits])

    def crossings(origins, directions):
        return [crossing(*line) for line in zip(origins, directions)]

    parts = manifold.decompose()
    return Rebuilt(
        kernel=NAME,
        mass=triangles.mass(corners),
        bounds_mm=numpy.array([low, high]),
        genus=sum(shell.genus() for shell in parts),
        shells=len(parts),
        chord_mm=CHORD_MM,
        crossings=crossings,
        contains=lambda points: triangles.contains(points, crossings),
        distance_mm=triangles.Distances(corners),
    )
