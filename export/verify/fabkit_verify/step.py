"""Writer of STEP files (AP242) with exact faces, names of parts and features, and colours.

Solids are rebuilt in OpenCascade. Each file is read back and checked: it must be valid, named, and have
the faces that were written and the exact volume.
"""

from __future__ import annotations

import itertools
import re
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Reader, STEPCAFControl_Writer
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Face, TopoDS_Shape
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from . import __version__, document
from .face_names import face_names
from .kernels import occt
from .kernels.with_cadquery import StorableCadquery
from .measured import RebuildError
from .walk import build

# Largest relative difference of written and exact volume; STEP has 15 digits.
VOLUME = 1e-6
# Fixed, so that files depend only on the design.
TIME_STAMP = "1970-01-01T00:00:00"
# Name of the assembly that is the sensor in use.
SENSOR = "sensor"


@dataclass(frozen=True)
class StepJob:
    """Writing of one file: a part, or (`assembly`) all bodies in their poses in the sensor."""

    folder: Path
    output: Path
    name: str
    assembly: bool = False

    def run(self) -> dict[str, Any]:
        """Writes the file, reads it back and checks it."""
        start = time.monotonic()
        try:
            parts, faces = self._assembly() if self.assembly else self._part()
        except Exception as error:  # pylint: disable=broad-exception-caught
            # OpenCascade's exceptions have no common base class.
            return self.failed(f"{type(error).__name__}: {error}", time.monotonic() - start)
        return {
            "name": f"{self.name}.step",
            "parts": parts,
            "faces": faces,
            "passed": True,
            "reason": "",
            "seconds": round(time.monotonic() - start, 2),
        }

    def failed(self, reason: str, seconds: float) -> dict[str, Any]:
        """Returns the result of a file that was not written."""
        return {
            "name": f"{self.name}.step",
            "parts": [self.name],
            "faces": {},
            "passed": False,
            "reason": reason,
            "seconds": round(seconds, 2),
        }

    def _part(self) -> tuple[list[str], dict[str, int]]:
        file = _File()
        body = _load(self.folder, self.name)
        file.add(body)
        path = self.output / f"{self.name}.step"
        file.write(path, self.name)
        read, names = _read(path)
        if names != [self.name]:
            raise RebuildError(f"the file names {names}, not {self.name}")
        _check_same(body.shape, read, body.volume_mm3)
        return [self.name], occt.face_types(read)

    def _assembly(self) -> tuple[list[str], dict[str, int]]:
        file, parts, volume = _File(), [], 0.0
        root = file.shapes.NewShape()
        TDataStd_Name.Set_s(root, TCollection_ExtendedString(self.name))
        for path in sorted(self.folder.glob("*.tree.json")):
            name = path.name.removesuffix(".tree.json")
            placements = [
                placement["assembly_from_body"]
                for placement in document.read(path)["placements"]
                if placement["assembly"] == SENSOR
            ]
            if not placements:
                continue
            body = _load(self.folder, name)
            label = file.add(body)
            for number, pose in enumerate(placements, 1):
                place = TopLoc_Location(occt.rigid(pose))
                component = file.shapes.AddComponent(root, label, place)
                title = name if len(placements) == 1 else f"{name} {number}"
                TDataStd_Name.Set_s(component, TCollection_ExtendedString(title))
                parts.append(name)
                volume += body.volume_mm3
        file.shapes.UpdateAssemblies()
        path = self.output / f"{self.name}.step"
        file.write(path, self.name)
        read, names = _read(path)
        if names != [self.name]:
            raise RebuildError(f"the file names {names}, not {self.name}")
        _check_volume(occt.volume_mm3(read), volume)
        return parts, occt.face_types(read)


@dataclass(frozen=True)
class _Body:
    """A body's tree, its solid, its faces with the names of their features, and its exact volume."""

    tree: dict
    shape: TopoDS_Shape
    faces: list[tuple[TopoDS_Face, str]]
    volume_mm3: float


def _load(folder: Path, name: str) -> _Body:
    """Reads a body's documents, rebuilds its solid and names its faces."""
    tree = document.read(folder / f"{name}.tree.json")
    samples = document.read_samples(folder / f"{name}.samples.json")
    shape = _unwrapped(build(tree["solid"], StorableCadquery()).wrapped)
    if not BRepCheck_Analyzer(shape).IsValid():
        raise RebuildError(f"{name}: OpenCascade calls its own shape invalid")
    volume = samples["figures"]["volume_mm3"]
    _check_volume(occt.volume_mm3(shape), volume)
    probe = occt.Probe(shape)
    names = face_names(tree, samples, probe)
    return _Body(tree, shape, list(zip(probe.faces, names)), volume)


def _unwrapped(shape: TopoDS_Shape) -> TopoDS_Shape:
    """Removes a placement, and a compound around a single solid: with either, STEP would store a part as
    an assembly."""
    solids = occt.subshapes(shape, TopAbs_SOLID)
    if solids.Extent() == 1:
        shape = solids.FindKey(1)
    place = shape.Location()
    if place.IsIdentity():
        return shape
    origin = shape.Located(TopLoc_Location())
    return BRepBuilderAPI_Transform(origin, place.Transformation(), True).Shape()


def _check_volume(found: float, exact: float) -> None:
    if not abs(found - exact) <= VOLUME * exact:
        raise RebuildError(f"{found} mm3, but the exact volume is {exact} mm3")


def _check_same(written: TopoDS_Shape, read: TopoDS_Shape, exact_mm3: float) -> None:
    """Checks that a shape that was read back is valid and equals the written one."""
    if not BRepCheck_Analyzer(read).IsValid():
        raise RebuildError("what was read back is not valid")
    _check_volume(occt.volume_mm3(read), exact_mm3)
    before, after = occt.face_types(written), occt.face_types(read)
    if before != after:
        raise RebuildError(f"{after} faces were read back, {before} were written")


class _File:
    """An OpenCascade document of named and coloured shapes."""

    def __init__(self) -> None:
        self.document = TDocStd_Document(TCollection_ExtendedString("fabkit"))
        self.shapes = XCAFDoc_DocumentTool.ShapeTool_s(self.document.Main())
        self.colors = XCAFDoc_DocumentTool.ColorTool_s(self.document.Main())

    def add(self, body: _Body) -> TDF_Label:
        """Adds a body and returns its label, to which placements refer."""
        tree = body.tree
        label = self.shapes.AddShape(body.shape, False)
        for face, name in body.faces:
            if name:
                of_face = self.shapes.AddSubShape(label, face)
                TDataStd_Name.Set_s(of_face, TCollection_ExtendedString(name))
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(tree["name"]))
        rgb = Quantity_Color(*(channel / 255 for channel in tree["color"]), Quantity_TOC_sRGB)
        color = Quantity_ColorRGBA(rgb, tree["opacity"])
        self.colors.SetColor(label, color, XCAFDoc_ColorType.XCAFDoc_ColorSurf)
        return label

    def write(self, path: Path, name: str) -> None:
        """Writes all shapes to a STEP file, in millimetres."""
        writer = STEPCAFControl_Writer()
        # 5 is AP242 in its first edition.
        Interface_Static.SetIVal_s("write.step.schema", 5)
        Interface_Static.SetCVal_s("write.step.unit", "MM")
        Interface_Static.SetIVal_s("write.stepcaf.subshapes.name", 1)
        writer.SetNameMode(True)
        writer.SetColorMode(True)
        writer.Transfer(self.document)
        header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
        header.SetName(TCollection_HAsciiString(name))
        header.SetTimeStamp(TCollection_HAsciiString(TIME_STAMP))
        header.SetOriginatingSystem(TCollection_HAsciiString(f"fabkit_verify {__version__}"))
        if writer.Write(str(path)) != IFSelect_RetDone:
            raise RebuildError(f"{path.name} could not be written")
        _number_occurrences(path)


def _number_occurrences(path: Path) -> None:
    """Renumbers the occurrences in assemblies from 1.

    OpenCascade counts them from the start of the process, so that files would depend on earlier ones.
    """
    numbers = itertools.count(1)
    text = path.read_text(encoding="utf-8")
    occurrence = r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\s*\()\s*'\d+'"
    text = re.sub(occurrence, lambda found: f"{found.group(1)}'{next(numbers)}'", text)
    path.write_text(text, encoding="utf-8")


def _read(path: Path) -> tuple[TopoDS_Shape, list[str]]:
    """Reads a STEP file: its shape, and the names of its roots."""
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise RebuildError(f"{path.name} could not be read back")
    back = TDocStd_Document(TCollection_ExtendedString("fabkit"))
    reader.Transfer(back)
    roots = TDF_LabelSequence()
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(back.Main())
    shapes.GetFreeShapes(roots)
    labels = [roots.Value(i) for i in range(1, roots.Length() + 1)]
    return shapes.GetOneShape(), [_name(label) for label in labels]


def _name(label: TDF_Label) -> str:
    name = TDataStd_Name()
    return name.Get().ToExtString() if label.FindAttribute(TDataStd_Name.GetID_s(), name) else ""
