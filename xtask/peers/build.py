"""One part in one kernel: `build.py KERNEL TREE TOLERANCE_MM STL`, with `fabkit_verify` on the path.

Prints one JSON object: CPU seconds of building, meshing and writing, imports not counted, and the
volume of the kernel's own exact solid where it has one.
"""

import importlib
import json
import sys
import time
from pathlib import Path

import numpy


def with_manifold3d(tree, tolerance_mm, stl):
    """As meshes throughout."""
    from fabkit_verify.kernels import with_manifold3d as kernel
    from fabkit_verify.walk import build

    kernel.CHORD_MM = tolerance_mm

    def work():
        solid = build(tree["solid"], kernel.Manifold3d())
        mesh = solid.to_mesh()
        corners = mesh.vert_properties[:, :3][mesh.tri_verts]
        normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= numpy.maximum(numpy.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
        record = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
        records = numpy.zeros(len(corners), numpy.dtype(record))
        records["normal"], records["corners"] = normals, corners
        stl.write_bytes(bytes(80) + numpy.uint32(len(corners)).tobytes() + records.tobytes())

    return work, lambda: None


def with_occt(name):
    """As exact solids, meshed at the end. The exporters of cadquery and build123d would mesh at a
    tolerance relative to each edge; this is what they call, at an absolute one."""

    def kernel(tree, tolerance_mm, stl):
        from OCP.BRepGProp import BRepGProp
        from OCP.BRepMesh import BRepMesh_IncrementalMesh
        from OCP.GProp import GProp_GProps
        from OCP.StlAPI import StlAPI_Writer

        solid = importlib.import_module(f"fabkit_verify.kernels.with_{name}").solid
        shapes = []

        def work():
            shapes.append(solid(tree).wrapped)
            BRepMesh_IncrementalMesh(shapes[0], tolerance_mm, False, 0.5, False)
            writer = StlAPI_Writer()
            writer.ASCIIMode = False
            if not writer.Write(shapes[0], str(stl)):
                raise OSError(f"cannot write {stl}")

        def exact_mm3():
            properties = GProp_GProps()
            BRepGProp.VolumeProperties_s(shapes[0], properties, 1e-9, False, False)
            return properties.Mass()

        return work, exact_mm3

    return kernel


KERNELS = {
    "manifold3d": with_manifold3d,
    "cadquery": with_occt("cadquery"),
    "build123d": with_occt("build123d"),
}


def main():
    name, tree_path, tolerance, stl = sys.argv[1:]
    tree = json.loads(Path(tree_path).read_text(encoding="utf-8"))
    work, exact_mm3 = KERNELS[name](tree, float(tolerance), Path(stl))
    start = time.process_time()
    work()
    seconds = time.process_time() - start
    print(json.dumps({"cpu_s": seconds, "exact_mm3": exact_mm3()}))


if __name__ == "__main__":
    main()
