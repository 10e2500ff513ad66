"""Vectorised evaluation of points and normals on OpenCascade's surfaces.

Surfaces of revolution and planes are evaluated here with numpy, from their meridians; for other surfaces
OpenCascade is called for each point.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Pnt, gp_Vec

# Maps u [n, m] and v [n] to points and to the normals S_u x S_v, both [n, m, 3], mm.
Surface = Callable[[numpy.ndarray, numpy.ndarray], tuple[numpy.ndarray, numpy.ndarray]]
# Maps v [n] to a point [n, 3] and its derivative [n, 3] in the frame whose z is the axis.
Meridian = Callable[[numpy.ndarray], tuple[numpy.ndarray, numpy.ndarray]]


def evaluator(adaptor: BRepAdaptor_Surface) -> Surface:
    """Returns the function that evaluates a face's surface."""
    match adaptor.GetType():
        case GeomAbs_SurfaceType.GeomAbs_Plane:
            return _plane(adaptor)
        case GeomAbs_SurfaceType.GeomAbs_Cylinder:
            cylinder = adaptor.Cylinder()
            return _turned(*_axes(cylinder.Position()), _line(cylinder.Radius(), 0.0))
        case GeomAbs_SurfaceType.GeomAbs_Cone:
            cone = adaptor.Cone()
            return _turned(*_axes(cone.Position()), _line(cone.RefRadius(), cone.SemiAngle()))
        case GeomAbs_SurfaceType.GeomAbs_Sphere:
            sphere = adaptor.Sphere()
            return _turned(*_axes(sphere.Position()), _circle(0.0, sphere.Radius()))
        case GeomAbs_SurfaceType.GeomAbs_Torus:
            torus = adaptor.Torus()
            meridian = _circle(torus.MajorRadius(), torus.MinorRadius())
            return _turned(*_axes(torus.Position()), meridian)
        case GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution:
            return _revolution(adaptor)
        case _:
            return _any(adaptor)


def _triple(of) -> list[float]:
    return [of.X(), of.Y(), of.Z()]


def _axes(position) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns the origin, and the three directions in rows; they may be left-handed."""
    directions = position.XDirection(), position.YDirection(), position.Direction()
    return numpy.array(_triple(position.Location())), numpy.array([*map(_triple, directions)])


def _plane(adaptor: BRepAdaptor_Surface) -> Surface:
    origin, (x, y, _) = _axes(adaptor.Plane().Position())

    def at(u, v):
        points = origin + u[..., None] * x + v[:, None, None] * y
        return points, numpy.broadcast_to(numpy.cross(x, y), points.shape)

    return at


def _line(radius_mm: float, slope: float) -> Meridian:
    """Creates a straight meridian, `radius_mm` from the axis at v = 0, `slope` rad from the axis."""
    sin, cos = numpy.sin(slope), numpy.cos(slope)

    def at(v):
        still, one = numpy.zeros_like(v), numpy.ones_like(v)
        points = numpy.stack([radius_mm + v * sin, still, v * cos], -1)
        return points, numpy.stack([one * sin, still, one * cos], -1)

    return at


def _circle(ring_mm: float, radius_mm: float) -> Meridian:
    """Creates a circular meridian around a point `ring_mm` from the axis."""

    def at(v):
        still, sin, cos = numpy.zeros_like(v), radius_mm * numpy.sin(v), radius_mm * numpy.cos(v)
        points = numpy.stack([ring_mm + cos, still, sin], -1)
        return points, numpy.stack([-sin, still, cos], -1)

    return at


def _revolution(adaptor: BRepAdaptor_Surface) -> Surface:
    axis, curve = adaptor.AxeOfRevolution(), adaptor.BasisCurve()
    origin, z = numpy.array(_triple(axis.Location())), numpy.array(_triple(axis.Direction()))
    x = numpy.cross(z, numpy.eye(3)[numpy.abs(z).argmin()])
    x /= numpy.linalg.norm(x)
    directions = numpy.array([x, numpy.cross(z, x), z])

    def meridian(v):
        point, speed = gp_Pnt(), gp_Vec()
        rows = numpy.empty((len(v), 2, 3))
        for row, parameter in zip(rows, v):
            curve.D1(float(parameter), point, speed)
            row[0], row[1] = _triple(point), _triple(speed)
        return (rows[:, 0] - origin) @ directions.T, rows[:, 1] @ directions.T

    return _turned(origin, directions, meridian)


def _turned(origin: numpy.ndarray, directions: numpy.ndarray, meridian: Meridian) -> Surface:
    """Creates the surface of a meridian that is rotated by the angle u about z."""

    def at(u, v):
        (x, y, z), (dx, dy, dz) = (values.T[..., None] for values in meridian(v))
        sin, cos, level = numpy.sin(u), numpy.cos(u), numpy.zeros_like(u)
        out, aside = cos * x - sin * y, sin * x + cos * y
        points = numpy.stack([out, aside, z + level], -1)
        along_u = numpy.stack([-aside, out, level], -1)
        along_v = numpy.stack([cos * dx - sin * dy, sin * dx + cos * dy, dz + level], -1)
        return origin + points @ directions, numpy.cross(along_u @ directions, along_v @ directions)

    return at


def _any(adaptor: BRepAdaptor_Surface) -> Surface:
    """Creates a surface that calls OpenCascade for each point."""
    def at(u, v):
        points, normals = numpy.empty((*u.shape, 3)), numpy.empty((*u.shape, 3))
        point, along_u, along_v = gp_Pnt(), gp_Vec(), gp_Vec()
        for (row, column), parameter in numpy.ndenumerate(u):
            adaptor.D1(float(parameter), float(v[row]), point, along_u, along_v)
            points[row, column] = _triple(point)
            normals[row, column] = _triple(along_u.Crossed(along_v))
        return points, normals

    return at
