"""The kernel build123d. Its booleans clean up their result, which silently ruins spheres: that is
switched off here."""

from __future__ import annotations

from build123d import Axis, Compound, Edge, Face, Location, Plane, Shape, SkipClean, Solid, Vector
from build123d import Wire

from ..curves import Piece, pieces
from ..measured import Rebuilt, RebuildError
from ..walk import build
from . import occt

NAME = "build123d"

# Profiles of revolutions lie in the half plane y = 0, x >= 0, seen along +y.
_MERIDIAN_NORMAL = (0, -1, 0)


class Build123d:
    """Builds shapes by build123d's own constructors and booleans."""

    def sphere(self, radius_mm):
        return Solid.make_sphere(radius_mm)

    def ellipsoid(self, semi_axes_mm):
        a, b, c = semi_axes_mm
        if a == b:
            return self.ellipsoid_offset(a, c, 0.0)
        return Solid(occt.scaled_ball(self.sphere(1.0).wrapped, semi_axes_mm))

    def cylinder(self, radius_mm, height_mm):
        return Solid.make_cylinder(radius_mm, height_mm)

    def cone(self, bottom_radius_mm, top_radius_mm, height_mm):
        return Solid.make_cone(bottom_radius_mm, top_radius_mm, height_mm)

    def cuboid(self, size_mm):
        x, y, z = size_mm
        return Solid.make_box(x, y, z, Plane((-x / 2, -y / 2, 0)))

    def torus(self, ring_radius_mm, tube_radius_mm):
        return Solid.make_torus(ring_radius_mm, tube_radius_mm)

    def extrusion(self, profile, height_mm):
        face = _face(profile, lambda p: Vector(p[0], p[1], 0), up=(0, 0, 1))
        return Solid.extrude(face, Vector(0, 0, height_mm))

    def revolution(self, profile):
        face = _face(profile, lambda p: Vector(p[0], 0, p[1]), _MERIDIAN_NORMAL)
        return Solid.revolve(face, 360, Axis.Z)

    def ellipsoid_offset(self, equatorial_mm, polar_mm, offset_mm):
        edge = Edge(occt.parallel_of_half_ellipse(equatorial_mm, polar_mm, offset_mm))
        height = polar_mm + offset_mm
        axis = Edge.make_line((0, 0, height), (0, 0, -height))
        return Solid.revolve(Face(Wire([edge, axis])), 360, Axis.Z)

    def half_space(self, reach_mm):
        return self.cuboid([2 * reach_mm] * 3).moved(Location((0, 0, -2 * reach_mm)))

    def union(self, shapes):
        with SkipClean():
            return _one(shapes[0].fuse(*shapes[1:])) if len(shapes) > 1 else shapes[0]

    def intersection(self, shapes):
        result = shapes[0]
        with SkipClean():
            for other in shapes[1:]:
                result = _one(result.intersect(other))
        return result

    def difference(self, shape, tools):
        with SkipClean():
            return _one(shape.cut(*tools)) if tools else shape

    def placed(self, shape, pose):
        return shape.moved(Location(occt.rigid(pose)))


def _one(result) -> Shape:
    """Converts a boolean's result (a shape, a list of shapes or nothing) to one shape."""
    if result is None:
        raise RebuildError(f"{NAME}: a boolean leaves nothing")
    if isinstance(result, Shape):
        return result
    shapes = list(result)
    return shapes[0] if len(shapes) == 1 else Compound(shapes)


def _face(profile, to_space, up) -> Face:
    outer, *holes = (
        Wire([_edge(piece, to_space, up) for piece in pieces(path)])
        for path in [profile["outer"], *profile.get("holes", [])]
    )
    return Face(outer, holes)


def _edge(piece: Piece, to_space, up) -> Edge:
    if piece.kind == "line":
        return Edge.make_line(to_space(piece.start), to_space(piece.to))
    if piece.kind == "arc":
        ends = (to_space(piece.start), to_space(piece.at(0.5)), to_space(piece.to))
        return Edge.make_three_point_arc(*ends)
    return Edge(occt.elliptic_arc(piece, to_space, up))


def solid(tree: dict) -> Shape:
    """The solid of a tree document."""
    return build(tree["solid"], Build123d())


def rebuild(tree: dict, samples: dict, folder: object) -> Rebuilt:
    """The solid with its measures."""
    del samples, folder
    return occt.rebuilt(NAME, solid(tree).wrapped)
