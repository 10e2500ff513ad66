"""The kernel cadquery. Its `clean` silently ruins spheres and is never called."""

from __future__ import annotations

import cadquery

from ..curves import Piece, pieces
from ..measured import Rebuilt
from ..walk import build
from . import occt

NAME = "cadquery"


class Cadquery:
    """Builds shapes by cadquery's own constructors and booleans."""

    def sphere(self, radius_mm):
        return cadquery.Solid.makeSphere(radius_mm, angleDegrees1=-90, angleDegrees2=90)

    def ellipsoid(self, semi_axes_mm):
        a, b, c = semi_axes_mm
        if a == b:
            return self.ellipsoid_offset(a, c, 0.0)
        return cadquery.Shape.cast(occt.scaled_ball(self.sphere(1.0).wrapped, semi_axes_mm))

    def cylinder(self, radius_mm, height_mm):
        return cadquery.Solid.makeCylinder(radius_mm, height_mm)

    def cone(self, bottom_radius_mm, top_radius_mm, height_mm):
        return cadquery.Solid.makeCone(bottom_radius_mm, top_radius_mm, height_mm)

    def cuboid(self, size_mm):
        x, y, z = size_mm
        return cadquery.Solid.makeBox(x, y, z, cadquery.Vector(-x / 2, -y / 2, 0))

    def torus(self, ring_radius_mm, tube_radius_mm):
        return cadquery.Solid.makeTorus(ring_radius_mm, tube_radius_mm)

    def extrusion(self, profile, height_mm):
        wires = _wires(profile, lambda p: cadquery.Vector(p[0], p[1], 0), up=(0, 0, 1))
        return cadquery.Solid.extrudeLinear(
            wires[0], wires[1:], cadquery.Vector(0, 0, height_mm)
        )

    def revolution(self, profile):
        wires = _wires(profile, lambda p: cadquery.Vector(p[0], 0, p[1]), up=(0, -1, 0))
        return cadquery.Solid.revolve(
            wires[0], wires[1:], 360, cadquery.Vector(0, 0, 0), cadquery.Vector(0, 0, 1)
        )

    def ellipsoid_offset(self, equatorial_mm, polar_mm, offset_mm):
        edge = self.meridian(equatorial_mm, polar_mm, offset_mm)
        height = polar_mm + offset_mm
        axis = cadquery.Edge.makeLine(
            cadquery.Vector(0, 0, height), cadquery.Vector(0, 0, -height)
        )
        wire = cadquery.Wire.assembleEdges([cadquery.Edge(edge), axis])
        return cadquery.Solid.revolve(
            wire, [], 360, cadquery.Vector(0, 0, 0), cadquery.Vector(0, 0, 1)
        )

    def meridian(self, across_mm, along_mm, offset_mm):
        return occt.parallel_of_half_ellipse(across_mm, along_mm, offset_mm)

    def half_space(self, reach_mm):
        return self.cuboid([2 * reach_mm] * 3).moved(cadquery.Location((0, 0, -2 * reach_mm)))

    def union(self, shapes):
        return shapes[0].fuse(*shapes[1:]) if len(shapes) > 1 else shapes[0]

    def intersection(self, shapes):
        # One at a time: several tools in one call would be united first.
        result = shapes[0]
        for other in shapes[1:]:
            result = result.intersect(other)
        return result

    def difference(self, shape, tools):
        return shape.cut(*tools) if tools else shape

    def placed(self, shape, pose):
        return shape.moved(cadquery.Location(occt.rigid(pose)))


class StorableCadquery(Cadquery):
    """Builds only shapes that STEP files can hold."""

    def meridian(self, across_mm, along_mm, offset_mm):
        return occt.storable(super().meridian(across_mm, along_mm, offset_mm))


def _wires(profile, to_space, up) -> list[cadquery.Wire]:
    paths = [profile["outer"], *profile.get("holes", [])]
    return [
        cadquery.Wire.assembleEdges([_edge(piece, to_space, up) for piece in pieces(path)])
        for path in paths
    ]


def _edge(piece: Piece, to_space, up) -> cadquery.Edge:
    if piece.kind == "line":
        return cadquery.Edge.makeLine(to_space(piece.start), to_space(piece.to))
    if piece.kind == "arc":
        ends = (to_space(piece.start), to_space(piece.at(0.5)), to_space(piece.to))
        return cadquery.Edge.makeThreePointArc(*ends)
    return cadquery.Edge(occt.elliptic_arc(piece, to_space, up))


def solid(tree: dict) -> cadquery.Shape:
    """Builds the solid of a tree document."""
    return build(tree["solid"], Cadquery())


def rebuild(tree: dict, samples: dict, folder: object) -> Rebuilt:
    """Builds the solid of a tree document and measures it."""
    del samples, folder
    return occt.rebuilt(NAME, solid(tree).wrapped)
