"""Centroid and inertia of OpenCascade's solids, integrated over their exact faces.

OpenCascade has two rules for them. Gaussian quadrature of fixed order states no error and is off by 3 um
for the centroid of a half dome, whose large faces are trimmed by many curves. The adaptive rule adapts
only to the volume; where that is simple (a sphere, a cone), moments are off by up to 0.1 mm. So the faces
are integrated here, from OpenCascade's surfaces and the curves that trim them.

By the divergence theorem, the integral over a solid of a homogeneous polynomial p of degree k is that of
p (r . n) over its surface, divided by k + 3. On a face with parameters u and v, Green's theorem turns it
into an integral along the trimming curves, of the inner integral over u from a fixed parameter to the
curve. Both use Gauss-Legendre quadrature on panels that are halved until the result no longer changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy
from OCP.BRepAdaptor import BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_CN
from OCP.gp import gp_Pnt2d, gp_Vec2d
from OCP.TColStd import TColStd_Array1OfReal
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Face, TopoDS_Shape

from .occt_surfaces import evaluator

# Nodes of a panel. The integrand has at most four waves in a turn: one panel has a relative error of 2e-9.
NODES, WEIGHTS = numpy.polynomial.legendre.leggauss(16)
# Halving stops when a face changes by less than this share of the whole box, or after so many times.
CHANGE = 1e-11
HALVINGS = 6


@dataclass(frozen=True)
class Moments:
    """Volume, centroid and inertia of a solid of density 1. Errors are the change at the last halving."""

    volume_mm3: float
    centroid_mm: numpy.ndarray
    centroid_error_mm: float
    # Inertia about the centroid, 3 x 3.
    inertia_mm5: numpy.ndarray
    inertia_error_mm5: float


def moments(shape: TopoDS_Shape, bounds_mm: numpy.ndarray) -> Moments:
    """Integrates a closed shape; `bounds_mm` are its approximate lower and upper corner, 2 x 3."""
    middle = bounds_mm.mean(0)
    size = float(numpy.linalg.norm(bounds_mm[1] - bounds_mm[0]))
    # Upper bounds of the ten integrals for anything in the box: of degree 0, 1 and 2.
    most = size**3 * numpy.repeat([1.0, size, size**2], [1, 3, 6])
    total, change = numpy.zeros(10), numpy.zeros(10)
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        value, last = _Face(TopoDS.Face_s(explorer.Current()), middle).integrated(CHANGE * most)
        total += value
        change += numpy.abs(value - last)
        explorer.Next()
    volume, first, second = _unpacked(total)
    volume_error, first_error, second_error = _unpacked(change)
    centroid = first / volume
    spread = second - volume * numpy.outer(centroid, centroid)
    # Error propagation to first order; the centroid is not farther from the middle than the size.
    centroid_error = (float(numpy.linalg.norm(first_error)) + size * volume_error) / volume
    spread_error = second_error.max() + size * (2.0 * volume * centroid_error + size * volume_error)
    return Moments(
        volume_mm3=volume,
        centroid_mm=centroid + middle,
        centroid_error_mm=centroid_error,
        inertia_mm5=numpy.eye(3) * numpy.trace(spread) - spread,
        # Diagonal entries of the inertia are sums of two entries of the spread.
        inertia_error_mm5=2.0 * spread_error,
    )


def _unpacked(ten: numpy.ndarray) -> tuple[float, numpy.ndarray, numpy.ndarray]:
    """Splits ten integrals (1; x, y, z; xx, yy, zz, xy, yz, zx) into a number, a vector and a matrix."""
    xx, yy, zz, xy, yz, zx = ten[4:]
    second = numpy.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    return float(ten[0]), ten[1:4], second


class _Face:
    """One face, to integrate its share of the ten integrals about `middle`."""

    def __init__(self, face: TopoDS_Face, middle: numpy.ndarray):
        # In the forward orientation, and seen against the surface's normal, trimming curves have the face on
        # their left, as Green's theorem needs.
        forward = TopoDS.Face_s(face.Oriented(TopAbs_FORWARD))
        adaptor = BRepAdaptor_Surface(forward, True)
        self.middle = middle
        self.sign = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
        self.surface = evaluator(adaptor)
        self.breaks = _intervals(adaptor.NbUIntervals, adaptor.UIntervals)
        self.curves = []
        explorer = TopExp_Explorer(forward, TopAbs_EDGE)
        while explorer.More():
            edge = TopoDS.Edge_s(explorer.Current())
            # An edge of any other orientation lies inside the face and does not bound it.
            if edge.Orientation() in (TopAbs_FORWARD, TopAbs_REVERSED):
                self.curves.append(_Curve(edge, forward))
            explorer.Next()

    def integrated(self, enough: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Returns the integrals on the finest panels, and those on panels twice as long."""
        panels, last, value = 2, self._integral(1), self._integral(2)
        while (numpy.abs(value - last) > enough).any() and panels < 2**HALVINGS:
            panels *= 2
            value, last = self._integral(panels), value
        return value, last

    def _integral(self, panels: int) -> numpy.ndarray:
        u, v, dv = numpy.hstack([curve.sampled(panels) for curve in self.curves])
        nodes, weights = self._across(u, panels)
        points, normals = self.surface(nodes, v)
        points = points - self.middle
        flux = numpy.einsum("nmi,nmi->nm", points, normals) * weights * dv[:, None]
        x, y, z = numpy.moveaxis(points, -1, 0)
        forms = (numpy.ones_like(x) / 3, x / 4, y / 4, z / 4)
        forms += (x * x / 5, y * y / 5, z * z / 5, x * y / 5, y * z / 5, z * x / 5)
        return self.sign * numpy.array([(form * flux).sum() for form in forms])

    def _across(self, ends: numpy.ndarray, panels: int) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Returns nodes and weights [n, m] from the first u to each of `ends` [n]."""
        share, weight = _gauss(numpy.array([0.0, 1.0]), panels)
        # Outside its range of u the surface continues smoothly: no break there.
        starts, stops = self.breaks[:-1], numpy.append(self.breaks[1:-1], numpy.inf)
        nodes, weights = [], []
        for start, stop in zip(starts, stops):
            low = -numpy.inf if start == starts[0] else start
            length = (numpy.clip(ends, low, stop) - start)[:, None]
            nodes.append(start + length * share)
            weights.append(length * weight)
        return numpy.hstack(nodes), numpy.hstack(weights)


class _Curve:
    """A curve that trims a face, in the parameters of its surface."""

    def __init__(self, edge: TopoDS_Edge, face: TopoDS_Face):
        self.curve = BRepAdaptor_Curve2d(edge, face)
        self.sign = 1.0 if edge.Orientation() == TopAbs_FORWARD else -1.0
        self.breaks = _intervals(self.curve.NbIntervals, self.curve.Intervals)

    def sampled(self, panels: int) -> numpy.ndarray:
        """Returns u, v and the weighted dv at the quadrature nodes, in three rows."""
        parameters, weights = _gauss(self.breaks, panels)
        point, speed = gp_Pnt2d(), gp_Vec2d()
        columns = numpy.empty((3, len(parameters)))
        for i, parameter in enumerate(parameters):
            self.curve.D1(float(parameter), point, speed)
            columns[:, i] = point.X(), point.Y(), speed.Y()
        columns[2] *= self.sign * weights
        return columns


def _intervals(
    count: Callable[[object], int], fill: Callable[[TColStd_Array1OfReal, object], None]
) -> numpy.ndarray:
    """Returns both ends, and the parameters between them at which some derivative jumps."""
    ends = TColStd_Array1OfReal(1, count(GeomAbs_CN) + 1)
    fill(ends, GeomAbs_CN)
    return numpy.array([ends.Value(i) for i in range(1, ends.Length() + 1)])


def _gauss(ends: numpy.ndarray, panels: int) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Returns quadrature nodes and weights over all intervals, each divided into panels."""
    cuts = numpy.linspace(ends[:-1], ends[1:], panels + 1, axis=-1)
    low, high = cuts[:, :-1].ravel(), cuts[:, 1:].ravel()
    half, centre = 0.5 * (high - low), 0.5 * (high + low)
    return (centre[:, None] + half[:, None] * NODES).ravel(), (half[:, None] * WEIGHTS).ravel()
