"""Lets lib3mf and manifold3d read everything that `fabkit export` writes.

    python check_files.py PATH_TO_FABKIT

For every built-in sensor: each 3MF file is read by lib3mf (the 3MF Consortium's own library) in
strict mode and must give no warning, have millimetres as its unit and hold only closed, oriented
objects; each STL file, its equal vertices merged, must be a manifold to manifold3d, with the
volume, bounds and genus that the manifest states. Nothing here uses fabkit's own code.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import lib3mf
import manifold3d
import numpy

STL_TRIANGLE = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def fabkit(binary: str, *arguments: str) -> dict:
    done = subprocess.run([binary, "--json", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"fabkit {' '.join(arguments)}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def parts_of(model: lib3mf.Model, resource: lib3mf.Object) -> list[str]:
    """Names of the meshes that an object is made of; none of them may be moved."""
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


def main(binary: str) -> None:
    files = 0
    for sensor in fabkit(binary, "list")["sensors"]:
        bodies = sensor["parts"] + sensor["layers"]
        with tempfile.TemporaryDirectory() as folder:
            # All parts with their plates, then parts and layers one by one.
            for chosen in ([], [f"--part={name}" for name in bodies]):
                fabkit(binary, "export", sensor["name"], "-o", folder, *chosen)
                manifest = json.loads((Path(folder) / "manifest.json").read_text())
                parts = {part["name"]: part for part in manifest["parts"]}
                for file in manifest["files"]:
                    path = Path(folder) / file["name"]
                    if file["format"] == "3mf":
                        check_3mf(path, file["parts"], manifest["design_hash"])
                    elif file["format"] == "stl":
                        check_stl(path, parts[file["parts"][0]])
                    files += 1
    assert files > 0, "there was nothing to check"
    print(f"lib3mf and manifold3d accept all {files} files")


if __name__ == "__main__":
    main(sys.argv[1])
