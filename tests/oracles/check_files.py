"""Checks exported 3MF, STL, DXF and board files with lib3mf, manifold3d, ezdxf and OpenCV.

    python check_files.py PATH_TO_FABKIT [SENSOR...]

By default it checks every built-in sensor. lib3mf (the 3MF Consortium's own library) reads each 3MF file in strict mode
and must give no warning; the unit must be millimetres and all objects closed and oriented. manifold3d must accept each
STL file, with equal vertices merged, as a manifold with the volume, bounds and genus that the manifest states. Each DXF
file must pass ezdxf's audit without an error or a fix, be in millimetres, and enclose the area that the manifest states
and, exported without compensation, that of the profile in the part's tree. OpenCV must find each calibration board,
drawn from its SVG, with all corners at the positions in its document; its markers must be those of OpenCV's
dictionary, and its DXF must enclose the dark areas. Nothing here uses fabkit's own code.
"""

import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import ezdxf
import lib3mf
import manifold3d
import numpy
from ezdxf import units

STL_TRIANGLE = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def fabkit(binary: str, *arguments: str) -> dict:
    done = subprocess.run([binary, "--json", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"fabkit {' '.join(arguments)}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def parts_of(model: lib3mf.Model, resource: lib3mf.Object) -> list[str]:
    """Returns the names of the meshes that an object consists of; none of them may have a transform."""
    if not resource.IsComponentsObject():
        return [resource.GetName()]
    piece = model.GetComponentsObjectByID(resource.GetResourceID())
    components = [piece.GetComponent(i) for i in range(piece.GetComponentCount())]
    assert not any(c.HasTransform() for c in components), f"{piece.GetName()}: a moved component"
    return [c.GetObjectResource().GetName() for c in components]


def check_3mf(path: Path, names: list[str], design_hash: str) -> None:
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    warnings = [reader.GetWarning(i) for i in range(reader.GetWarningCount())]
    assert not warnings, f"{path.name}: {warnings}"
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter, f"{path.name}: unit {model.GetUnit()}"

    metadata = model.GetMetaDataGroup()
    found = {}
    for i in range(metadata.GetMetaDataCount()):
        entry = metadata.GetMetaData(i)
        found[entry.GetName()] = entry.GetValue()
    assert found["Application"].startswith("fabkit "), found
    assert found["DesignHash"] == design_hash, found
    assert found["Title"], found
    assert model.HasPackageThumbnailAttachment(), f"{path.name}: no picture"

    items = model.GetBuildItems()
    in_file = []
    while items.MoveNext():
        item = items.GetCurrent()
        assert not item.HasObjectTransform(), f"{path.name}: a build item has a transform"
        in_file += parts_of(model, item.GetObjectResource())
    assert in_file == names, f"{path.name}: {in_file}, the manifest says {names}"

    objects = model.GetMeshObjects()
    while objects.MoveNext():
        mesh = objects.GetCurrentMeshObject()
        assert mesh.IsValid(), f"{path.name}: {mesh.GetName()} is not valid"
        assert mesh.IsManifoldAndOriented(), f"{path.name}: {mesh.GetName()} is not manifold"
        vertices = numpy.array([list(v.Coordinates) for v in mesh.GetVertices()])
        assert vertices.min() >= 0, f"{path.name}: {mesh.GetName()} leaves the positive octant"


def check_stl(path: Path, part: dict) -> None:
    content = path.read_bytes()
    assert not content.startswith(b"solid"), f"{path.name} looks like text"
    (count,) = numpy.frombuffer(content, "<u4", 1, 80)
    assert len(content) == 84 + 50 * count, f"{path.name}: length and count disagree"
    triangles = numpy.frombuffer(content, STL_TRIANGLE, count, 84)
    corners = triangles["corners"].reshape(-1, 3)
    vertices, index = numpy.unique(corners, axis=0, return_inverse=True)
    mesh = manifold3d.Mesh(vertices, index.reshape(-1, 3).astype(numpy.uint32))
    solid = manifold3d.Manifold(mesh)
    assert solid.status() == manifold3d.Error.NoError, f"{path.name}: {solid.status()}"

    stated = part["mesh"]
    assert count == stated["triangles"], path.name
    genus = sum(shell.genus() for shell in solid.decompose())
    assert genus == stated["genus"], f"{path.name}: genus {genus}, stated {stated['genus']}"
    # A vertex moves by at most half an f32 step, 4e-6 mm at 64 mm; twice that over the whole area.
    bounds = numpy.array(part["bounds_in_file_mm"])
    step = numpy.spacing(numpy.float32(bounds.max()))
    slack = stated["area_mm2"] * 2 * step
    assert abs(solid.volume() - stated["volume_mm3"]) < slack, (
        f"{path.name}: {solid.volume()} mm3, stated {stated['volume_mm3']}"
    )
    difference = numpy.abs(numpy.array([vertices.min(0), vertices.max(0)]) - bounds).max()
    assert difference <= step, f"{path.name}: bounds differ by {difference} mm"

    a, b, c = (triangles["corners"][:, i].astype(float) for i in range(3))
    normals = numpy.cross(b - a, c - a)
    lengths = numpy.linalg.norm(normals, axis=1, keepdims=True)
    assert lengths.min() > 0, f"{path.name}: a triangle without area"
    difference = numpy.abs(normals / lengths - triangles["normal"]).max()
    assert difference < 1e-6, f"{path.name}: normals differ by {difference}"


def signed_area(points: list[tuple[float, float, float]]) -> float:
    """Computes the area within lines and arcs, positive if counter-clockwise; each point has its segment's bulge."""
    area = 0.0
    for (x0, y0, bulge), (x1, y1, _) in zip(points, points[1:] + points[:1]):
        area += (x0 * y1 - x1 * y0) / 2
        if bulge:
            angle = 4 * math.atan(bulge)
            radius = math.hypot(x1 - x0, y1 - y0) / (2 * math.sin(angle / 2))
            area += radius**2 * (angle - math.sin(angle)) / 2
    return area


def area_of_polyline(points: list[tuple[float, float, float]]) -> float:
    return abs(signed_area(points))


def area_of_path(path: dict) -> float:
    """Computes the area within a path of a tree file."""
    points, start = [], path["start"]
    for segment in path["segments"]:
        ((kind, how),) = segment.items()
        bulge = 0.0
        if kind == "arc":
            first, last = (
                math.atan2(p[1] - how["centre"][1], p[0] - how["centre"][0]) for p in (start, how["to"])
            )
            turn = last - first if how["ccw"] else first - last
            bulge = math.tan(turn % math.tau / 4) * (1 if how["ccw"] else -1)
        points.append((*start, bulge))
        start = how["to"]
    return area_of_polyline(points)


def area_of_tree(path: Path) -> float:
    """Computes the cross-section of the single extrusion, cylinder or box in a tree file, mm2."""
    node = json.loads(path.read_text())["solid"]
    while True:
        ((kind, node),) = node.items()
        if kind in ("placed", "feature"):
            node = node["of"]
        elif kind == "cylinder":
            return math.pi * node["radius_mm"] ** 2
        elif kind == "cuboid":
            return node["size_mm"][0] * node["size_mm"][1]
        else:
            profile = node["profile"]
            holes = sum(area_of_path(hole) for hole in profile.get("holes", []))
            return area_of_path(profile["outer"]) - holes


def check_dxf(path: Path, area: float) -> None:
    document = ezdxf.readfile(path)
    audit = document.audit()
    found = [str(entry.message) for entry in audit.errors + audit.fixes]
    assert not found, f"{path.name}: {found}"
    assert document.dxfversion >= "AC1015", f"{path.name}: {document.dxfversion}"
    assert document.units == units.MM, f"{path.name}: unit {document.units}"
    enclosed = 0.0
    for entity in document.modelspace():
        layer = entity.dxf.layer
        assert layer in document.layers, f"{path.name}: layer {layer} is not in the table"
        if layer == "LABEL":
            continue
        sign = {"CUT_OUTER": 1, "CUT_INNER": -1}[layer]
        if entity.dxftype() == "CIRCLE":
            enclosed += sign * math.pi * entity.dxf.radius**2
        else:
            assert entity.dxftype() == "LWPOLYLINE" and entity.closed, f"{path.name}: {entity}"
            enclosed += sign * area_of_polyline(list(entity.get_points("xyb")))
    assert abs(enclosed - area) < 1e-6 * area, f"{path.name}: {enclosed} mm2, not {area}"


PIXELS_PER_MM = 8


def dark_of_svg(path: Path) -> list[numpy.ndarray]:
    """Reads the polygons of the filled path, mm."""
    (data,) = re.findall(r'evenodd" d="([^"]*)"', path.read_text())
    numbers = (re.findall(r"[-+.e0-9]+", part) for part in data.split("M")[1:])
    return [numpy.array(part, float).reshape(-1, 2)[:-1] for part in numbers]


def check_board(folder: Path, kind: str) -> None:
    board = json.loads((folder / f"{kind}.board.json").read_text())
    columns, rows = board["squares"]
    corners = numpy.array([corner["in_board_mm"] for corner in board["corners"]])
    dark = dark_of_svg(folder / f"{kind}.svg")
    # fillPoly uses the even-odd rule, as the file does; fixed point gives subpixel edges.
    size = numpy.ceil(numpy.concatenate(dark).max(axis=0) * PIXELS_PER_MM).astype(int) + 60
    image = numpy.full((size[1], size[0]), 255, numpy.uint8)
    # Pixel centres are whole numbers, so an edge at x mm lies at x * scale - 0.5.
    fixed = [numpy.round((p * PIXELS_PER_MM - 0.5) * 256).astype(numpy.int32) for p in dark]
    cv2.fillPoly(image, fixed, 0, shift=8)
    if kind == "charuco":
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board["dictionary"]))
        for marker in board["markers"]:
            known = dictionary.bytesList[marker["id"] : marker["id"] + 1]
            bits = cv2.aruco.Dictionary.getBitsFromByteList(known, dictionary.markerSize)
            assert ["".join(map(str, row)) for row in bits] == marker["bits"], marker
        layout = cv2.aruco.CharucoBoard(
            (columns, rows), board["square_mm"], board["marker_mm"], dictionary
        )
        assert numpy.abs(layout.getChessboardCorners()[:, :2] - corners).max() < 1e-4
        found, ids, _, _ = cv2.aruco.CharucoDetector(layout).detectBoard(image)
        assert sorted(ids.ravel()) == list(range(len(corners))), f"{len(ids)} corners found"
        found = found.reshape(-1, 2)[numpy.argsort(ids.ravel())]
    else:
        is_found, found = cv2.findChessboardCornersSB(image, (columns - 1, rows - 1))
        assert is_found, f"no {kind} found"
        found = found.reshape(-1, 2)
        # This detector cannot tell the board's ends apart: it may start at the other one.
        if found[0].sum() > found[-1].sum():
            found = found[::-1]
    off = (found + 0.5) / PIXELS_PER_MM - corners
    spread = numpy.abs(off - off.mean(axis=0)).max()
    # The drawn edges are rounded to pixels.
    assert spread < 0.3 / PIXELS_PER_MM, f"{kind}: corners are off by up to {spread} mm"

    document = ezdxf.readfile(folder / f"{kind}.dxf")
    assert not document.audit().errors and document.units == units.MM
    outlines = [e for e in document.modelspace() if e.dxf.layer == "ENGRAVE"]
    # Outlines of dark and light areas have opposite directions, so light ones subtract.
    enclosed = sum(signed_area(list(e.get_points("xyb"))) for e in outlines)
    area = (columns * rows - columns * rows // 2) * board["square_mm"] ** 2
    for marker in board.get("markers", []):
        light = "".join(marker["bits"]).count("1")
        area += (36 - light) * (board["marker_mm"] / 6) ** 2
    assert abs(abs(enclosed) - area) < 1e-6 * area, f"{kind}.dxf: {enclosed} mm2, not {area}"


def main(binary: str, names: list[str]) -> None:
    files = 0
    listed = fabkit(binary, "list")["sensors"]
    sensors = [sensor for sensor in listed if not names or sensor["name"] in names]
    for sensor in sensors:
        with tempfile.TemporaryDirectory() as folder:
            manifest = fabkit(binary, "export", f"{sensor['name']}/boards", "-o", folder)["manifest"]
            for file in manifest["files"]:
                if file["name"].endswith(".board.json"):
                    check_board(Path(folder), file["name"].removesuffix(".board.json"))
                    files += 4
    for sensor in sensors:
        bodies = sensor["parts"] + sensor["layers"]
        with tempfile.TemporaryDirectory() as folder:
            # All parts with their plates and stock sheets, as designed and as they are made, then
            # parts and layers one by one.
            nominal = ["--nominal", "--format=dxf,tree"]
            for chosen in (nominal, [], [f"--part={name}" for name in bodies]):
                fabkit(binary, "export", sensor["name"], "-o", folder, *chosen)
                manifest = json.loads((Path(folder) / "manifest.json").read_text())
                parts = {part["name"]: part for part in manifest["parts"]}
                for file in manifest["files"]:
                    path = Path(folder) / file["name"]
                    if file["format"] == "3mf":
                        check_3mf(path, file["parts"], manifest["design_hash"])
                    elif file["format"] == "stl":
                        check_stl(path, parts[file["parts"][0]])
                    elif file["format"] == "dxf":
                        check_dxf(path, sum(parts[n]["sheet"]["area_mm2"] for n in file["parts"]))
                    elif file["format"] == "tree" and "sheet" in (part := parts[file["parts"][0]]):
                        exact, stated = area_of_tree(path), part["sheet"]["area_mm2"]
                        assert abs(exact - stated) < 1e-9 * exact, f"{path.name}: {exact} mm2"
                    files += 1
    assert files > 0, "there was nothing to check"
    print(f"lib3mf, manifold3d, ezdxf and OpenCV accept all {files} files")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
