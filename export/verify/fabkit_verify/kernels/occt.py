"""OpenCascade shapes: construction and measurement that cadquery and build123d share."""

from __future__ import annotations

from collections import Counter

import numpy
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_GTransform,
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeVertex,
)
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepGProp import BRepGProp
from OCP.Geom import Geom_Ellipse, Geom_OffsetCurve, Geom_TrimmedCurve
from OCP.GeomAbs import GeomAbs_C2, GeomAbs_CurveType
from OCP.GeomConvert import GeomConvert_ApproxCurve
from OCP.gp import gp_Ax2, gp_Dir, gp_GTrsf, gp_Lin, gp_Mat, gp_Pnt, gp_Trsf
from OCP.GProp import GProp_GProps
from OCP.IntCurvesFace import IntCurvesFace_Intersector
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_IN, TopAbs_SHELL, TopAbs_SOLID
from OCP.TopAbs import TopAbs_VERTEX, TopAbs_WIRE
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Edge, TopoDS_Shape
from OCP.TopTools import TopTools_IndexedMapOfShape

from ..curves import Piece
from ..measured import Mass, Rebuilt, RebuildError
from .occt_moments import Moments, moments

# Requested accuracy of adaptive integration. Its own estimate is optimistic: with 1e-7 it was off by 9e-6
# on parallel surfaces of ellipsoids, with this value by 3e-9.
INTEGRATION = 1e-11
# Largest relative difference of a volume as integrated by OpenCascade and here; and largest error of a
# centroid over the size of the solid.
SAME_INTEGRAL = 1e-7
# Tolerance of splines for curves that STEP cannot hold, mm; far below OpenCascade's own 1e-7.
SPLINE_MM = 1e-9
# Nearer hits on both faces of an edge count as one crossing, mm.
EDGE_MM = 1e-7
# Margin around the faces' bounding boxes before lines are tested against them, mm.
BOX_MM = 1e-3


def rigid(pose: dict) -> gp_Trsf:
    """Converts a pose to OpenCascade's transform."""
    (a, b, c), t = pose["rotation"], pose["translation_mm"]
    motion = gp_Trsf()
    motion.SetValues(*a, t[0], *b, t[1], *c, t[2])
    return motion


def scaled_ball(sphere: TopoDS_Shape, factors: list[float]) -> TopoDS_Shape:
    """Creates an ellipsoid with three axes from a ball of radius 1, whose rational spline is scaled
    exactly."""
    matrix = gp_Mat(factors[0], 0, 0, 0, factors[1], 0, 0, 0, factors[2])
    stretch = gp_GTrsf()
    stretch.SetVectorialPart(matrix)
    return BRepBuilderAPI_GTransform(sphere, stretch, True).Shape()


def parallel_of_half_ellipse(across_mm: float, along_mm: float, offset_mm: float) -> TopoDS_Edge:
    """Creates a parallel curve of a half ellipse in the plane y = 0, from the lower to the upper pole.

    OpenCascade evaluates an offset curve from its basis, so this is exact; only the curves in which its
    revolution intersects other faces are splines.
    """
    long, short = max(across_mm, along_mm), min(across_mm, along_mm)
    # Parameter 0 lies on the longer axis; the plane's normal turns so that x stays above 0.
    direction = gp_Dir(1, 0, 0) if across_mm >= along_mm else gp_Dir(0, 0, -1)
    ellipse = Geom_Ellipse(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, -1, 0), direction), long, short)
    first = -numpy.pi / 2 if across_mm >= along_mm else 0.0
    curve = Geom_OffsetCurve(ellipse, offset_mm, gp_Dir(0, -1, 0)) if offset_mm else ellipse
    return BRepBuilderAPI_MakeEdge(curve, first, first + numpy.pi).Edge()


def storable(edge: TopoDS_Edge) -> TopoDS_Edge:
    """Replaces an offset curve by a spline; returns other edges as they are.

    OpenCascade silently leaves revolutions of offset curves out of STEP files.
    """
    adaptor = BRepAdaptor_Curve(edge)
    if adaptor.GetType() != GeomAbs_CurveType.GeomAbs_OffsetCurve:
        return edge
    first, last = adaptor.FirstParameter(), adaptor.LastParameter()
    curve = Geom_TrimmedCurve(BRep_Tool.Curve_s(edge, 0.0, 0.0), first, last)
    spline = GeomConvert_ApproxCurve(curve, SPLINE_MM, GeomAbs_C2, 1000, 8)
    if not spline.HasResult() or spline.MaxError() > SPLINE_MM:
        raise RebuildError("no spline follows a parallel of an ellipse closely enough")
    return BRepBuilderAPI_MakeEdge(spline.Curve()).Edge()


def elliptic_arc(piece: Piece, to_space, up: tuple[int, int, int]) -> TopoDS_Edge:
    """Creates an arc of an ellipse along its plane's axes; `up` is the plane's normal."""
    centre, (x, y) = tuple(to_space(piece.centre)), piece.semi_axes_mm
    # OpenCascade takes the longer axis first: if that is y, the ellipse is turned by a quarter.
    along = (1.0, 0.0) if x >= y else (0.0, 1.0)
    tip = tuple(to_space((piece.centre[0] + along[0], piece.centre[1] + along[1])))
    axes = gp_Ax2(
        gp_Pnt(*centre), gp_Dir(*up), gp_Dir(*(t - c for t, c in zip(tip, centre)))
    )
    first = piece.first - (0.0 if x >= y else numpy.pi / 2)
    low, high = sorted((first, first + piece.turn))
    ellipse = Geom_Ellipse(axes, max(x, y), min(x, y))
    return BRepBuilderAPI_MakeEdge(ellipse, low, high).Edge()


def subshapes(shape: TopoDS_Shape, kind) -> TopTools_IndexedMapOfShape:
    """Collects the different sub-shapes of one kind."""
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return found


def volume_mm3(shape: TopoDS_Shape) -> float:
    """Computes the volume by OpenCascade's adaptive integration."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, INTEGRATION, False, False)
    return properties.Mass()


def area_mm2(shape: TopoDS_Shape) -> float:
    """Computes the area by OpenCascade's adaptive integration."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties, INTEGRATION, False)
    return properties.Mass()


def face_types(shape: TopoDS_Shape) -> dict[str, int]:
    """Counts the faces by type of surface."""
    faces = subshapes(shape, TopAbs_FACE)
    names = Counter()
    for i in range(1, faces.Extent() + 1):
        kind = BRepAdaptor_Surface(TopoDS.Face_s(faces.FindKey(i)), False).GetType()
        names[kind.name.removeprefix("GeomAbs_").lower()] += 1
    return dict(sorted(names.items()))


class Probe:
    """Computes line crossings, containment and distances of points for one shape."""

    def __init__(self, shape: TopoDS_Shape):
        self.shape = shape
        found = subshapes(shape, TopAbs_FACE)
        self.faces = [TopoDS.Face_s(found.FindKey(i)) for i in range(1, found.Extent() + 1)]
        self.intersectors = [IntCurvesFace_Intersector(face, EDGE_MM) for face in self.faces]
        corners = []
        for face in self.faces:
            box = Bnd_Box()
            BRepBndLib.Add_s(face, box, False)
            box.SetGap(BOX_MM)
            corners.append(box.Get())
        boxes = numpy.array(corners).reshape(-1, 6)
        self.low, self.high = boxes[:, :3], boxes[:, 3:]

    def crossings(self, origins: numpy.ndarray, directions: numpy.ndarray) -> list[numpy.ndarray]:
        """Returns where lines cross the surface, sorted, mm along their unit directions."""
        return [self._crossings(*line) for line in zip(origins, directions)]

    def _crossings(self, origin: numpy.ndarray, direction: numpy.ndarray) -> numpy.ndarray:
        hits = [hit for _, of_face in self.faces_met(origin, direction) for hit in of_face]
        hits = numpy.sort(numpy.array(hits))
        return hits[numpy.diff(hits, prepend=-numpy.inf) > EDGE_MM]

    def faces_met(
        self, origin: numpy.ndarray, direction: numpy.ndarray
    ) -> list[tuple[int, list[float]]]:
        """Returns the numbers of the faces that a line crosses, and where, mm along its unit direction."""
        line = gp_Lin(gp_Pnt(*map(float, origin)), gp_Dir(*map(float, direction)))
        met = []
        for index in self._near(origin, direction):
            face = self.intersectors[index]
            face.Perform(line, -1e5, 1e5)
            if face.IsDone() and face.NbPnt() > 0:
                met.append((int(index), [face.WParameter(i) for i in range(1, face.NbPnt() + 1)]))
        return met

    def _near(self, origin: numpy.ndarray, direction: numpy.ndarray) -> numpy.ndarray:
        """Returns the faces whose bounding boxes a line crosses, by the slab method."""
        # A line perpendicular to an axis is inside that axis's slab everywhere or nowhere.
        with numpy.errstate(divide="ignore", invalid="ignore"):
            a, b = (self.low - origin) / direction, (self.high - origin) / direction
        still = direction == 0.0
        outside = ((origin < self.low) | (origin > self.high)) & still
        enter = numpy.where(still, -numpy.inf, numpy.minimum(a, b)).max(1)
        leave = numpy.where(still, numpy.inf, numpy.maximum(a, b)).min(1)
        return numpy.flatnonzero((enter <= leave) & ~outside.any(1))

    def contains(self, points: numpy.ndarray) -> list[bool]:
        """Returns for each point whether it is inside."""
        classifier = BRepClass3d_SolidClassifier(self.shape)
        inside = []
        for point in points:
            classifier.Perform(gp_Pnt(*map(float, point)), 1e-9)
            inside.append(classifier.State() == TopAbs_IN)
        return inside

    def distance_mm(self, point: numpy.ndarray) -> float:
        """Computes the distance from a point to the surface."""
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, point))).Vertex()
        shells = subshapes(self.shape, TopAbs_SHELL)
        distances = []
        for i in range(1, shells.Extent() + 1):
            extrema = BRepExtrema_DistShapeShape(vertex, shells.FindKey(i))
            distances.append(extrema.Value())
        return min(distances)


def genus(shape: TopoDS_Shape) -> int | None:
    """Counts through holes and handles, summed over shells, by the Euler-Poincaré formula.

    A face with k wires and no handle of its own counts 2 - k; every edge and vertex counts once. A
    degenerate edge (the pole of a sphere) does not count, a seam does; a closed edge has one vertex.
    None if two wires of a face touch: they then bound an unknown number of pieces.
    """
    total = 0
    shells = subshapes(shape, TopAbs_SHELL)
    for i in range(1, shells.Extent() + 1):
        shell = shells.FindKey(i)
        vertices = subshapes(shell, TopAbs_VERTEX).Extent()
        edges = subshapes(shell, TopAbs_EDGE)
        proper = [TopoDS.Edge_s(edges.FindKey(k)) for k in range(1, edges.Extent() + 1)]
        proper = [edge for edge in proper if not BRep_Tool.Degenerated_s(edge)]
        faces = subshapes(shell, TopAbs_FACE)
        characteristic = vertices - len(proper)
        for k in range(1, faces.Extent() + 1):
            wires = _wires(faces.FindKey(k))
            ends = [subshapes(wire, TopAbs_VERTEX).Extent() for wire in wires]
            if sum(ends) != subshapes(faces.FindKey(k), TopAbs_VERTEX).Extent():
                return None
            characteristic += 2 - len(wires)
        total += 1 - characteristic // 2
    return total


def _wires(face: TopoDS_Shape) -> list[TopoDS_Shape]:
    wires, explorer = [], TopExp_Explorer(face, TopAbs_WIRE)
    while explorer.More():
        wires.append(explorer.Current())
        explorer.Next()
    return wires


def bounds(shape: TopoDS_Shape) -> numpy.ndarray:
    """Computes the lower and upper corner of the smallest bounding box, mm."""
    box = Bnd_Box()
    # From exact faces, not triangles, and without adding the shape's tolerance.
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    values = box.Get()
    return numpy.array([values[:3], values[3:]])


def rebuilt(name: str, shape: TopoDS_Shape) -> Rebuilt:
    """Measures all properties of a shape. Raises RebuildError if it is invalid or no solid."""
    if shape is None or shape.IsNull() or subshapes(shape, TopAbs_SOLID).Extent() == 0:
        raise RebuildError(f"{name} leaves no solid")
    if not BRepCheck_Analyzer(shape).IsValid():
        raise RebuildError(f"{name} builds a shape that OpenCascade itself calls invalid")
    probe, corners = Probe(shape), bounds(shape)
    volume, integrated = volume_mm3(shape), moments(shape, corners)
    mass = Mass(volume, area_mm2(shape), integrated.centroid_mm, integrated.inertia_mm5)
    return Rebuilt(
        kernel=name,
        mass=mass,
        bounds_mm=corners,
        genus=genus(shape),
        shells=subshapes(shape, TopAbs_SHELL).Extent(),
        chord_mm=0.0,
        crossings=probe.crossings,
        contains=probe.contains,
        distance_mm=probe.distance_mm,
        complaints=_integration_faults(integrated, volume, corners),
        face_types=face_types(shape),
    )


def _integration_faults(integrated: Moments, volume: float, corners: numpy.ndarray) -> list[str]:
    """Lists reasons not to trust the integrals over a shape."""
    found = []
    if not abs(integrated.volume_mm3 - volume) <= SAME_INTEGRAL * abs(volume):
        found.append(
            f"its faces enclose {integrated.volume_mm3} mm3, but OpenCascade says {volume} mm3"
        )
    size = float(numpy.linalg.norm(corners[1] - corners[0]))
    if not integrated.centroid_error_mm <= SAME_INTEGRAL * size:
        found.append(f"its centroid is known to {integrated.centroid_error_mm:.1e} mm only")
    return found
