"""Checks exported tetrahedra of soft layers with Gmsh, meshio and scikit-fem.

    python check_tetrahedra.py PATH_TO_FABKIT [SENSOR...]

Both readers must find the same nodes, tetrahedra, materials and sets in `.msh`, and meshio in `.vtk`. Volumes and
angles between faces are computed independently. In a patch test with scikit-fem, a linear displacement of the whole
surface must be linear inside, which it is only if neighbours share their faces.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import gmsh
import meshio
import numpy as np
from skfem import Basis, BilinearForm, ElementTetP1, ElementVector, MeshTet, condense, solve
from skfem.helpers import ddot, sym_grad, trace

LEAST_DIHEDRAL_DEG = 15.0


def volumes(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    a, b, c, d = (points[cells[:, i]] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def least_dihedral_deg(points: np.ndarray, cells: np.ndarray) -> float:
    """Computes the least angle between faces: half a turn less the angle between their outward normals."""
    corners = points[cells]
    normals = []
    for i in range(4):
        a, b, c = (corners[:, j] for j in range(4) if j != i)
        normal = np.cross(b - a, c - a)
        sign = np.sign(np.einsum("ij,ij->i", normal, a - corners[:, i]))
        normals.append(normal * (sign / np.linalg.norm(normal, axis=1))[:, None])
    least = 180.0
    for i in range(4):
        for j in range(i):
            cosine = -np.einsum("ij,ij->i", normals[i], normals[j])
            least = min(least, np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))).min())
    return float(least)


def by_gmsh(path: Path) -> dict:
    gmsh.initialize(["", "-v", "2"])
    try:
        gmsh.open(str(path))
        tags, places, _ = gmsh.model.mesh.getNodes()
        points = np.zeros((len(tags), 3))
        points[tags.astype(int) - 1] = places.reshape(-1, 3)
        found = {"points": points}
        for dimension, tag in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dimension, tag)
            kind = 4 if dimension == 3 else 2
            nodes = []
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
                _, of_entity = gmsh.model.mesh.getElementsByType(kind, entity)
                nodes.append(of_entity.reshape(-1, dimension + 1).astype(int) - 1)
            found[name] = np.concatenate(nodes)
        return found
    finally:
        gmsh.finalize()


def by_meshio(path: Path) -> dict:
    mesh = meshio.read(path)
    found = {"points": mesh.points}
    names = {(dimension, tag): name for name, (tag, dimension) in mesh.field_data.items()}
    for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"], strict=True):
        dimension = {"tetra": 3, "triangle": 2}[block.type]
        for tag in np.unique(tags):
            found[names[dimension, tag]] = block.data[tags == tag]
    return found


def patch_test(points: np.ndarray, cells: np.ndarray) -> float:
    """Computes the error inside for a linear displacement of the surface, relative to the largest displacement."""
    mesh = MeshTet(np.ascontiguousarray(points.T), np.ascontiguousarray(cells.T))
    basis = Basis(mesh, ElementVector(ElementTetP1()))

    @BilinearForm
    def stiffness(u, v, _):
        return 2.0 * ddot(sym_grad(u), sym_grad(v)) + 1.5 * trace(sym_grad(u)) * trace(sym_grad(v))

    gradient = np.array([[0.01, 0.004, -0.002], [0.0, -0.006, 0.003], [0.005, 0.001, 0.002]])
    linear = (gradient @ points.T).T.reshape(-1)
    wanted = np.zeros(basis.N)
    for axis in range(3):
        wanted[basis.nodal_dofs[axis]] = linear[axis::3]
    surface = basis.get_dofs(mesh.boundary_facets()).all()
    found = solve(*condense(stiffness.assemble(basis), x=wanted, D=surface))
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


def check(fabkit: str, sensor: str, edge: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [fabkit, "export", sensor, "--quiet", "--format", "msh,vtk", "--edge", edge, "-o", folder]
        subprocess.run(command, check=True)
        about = json.loads((Path(folder) / f"{sensor}.tetrahedra.json").read_text())
        one, other = by_gmsh(Path(folder) / f"{sensor}.msh"), by_meshio(Path(folder) / f"{sensor}.msh")
        grid = meshio.read(Path(folder) / f"{sensor}.vtk")
    assert one.keys() == other.keys(), (one.keys(), other.keys())
    for name, values in one.items():
        assert np.array_equal(values, other[name]), name
    points = one["points"]
    assert np.array_equal(points, grid.points), "vtk has other nodes"
    cells = np.concatenate([one[layer["name"]] for layer in about["layers"]])
    (tetrahedra,) = (block.data for block in grid.cells if block.type == "tetra")
    assert sorted(map(tuple, tetrahedra)) == sorted(map(tuple, cells)), "vtk has other tetrahedra"
    assert (len(points), len(cells)) == (about["nodes"], about["tetrahedra"])
    for number, layer in enumerate(about["layers"], 1):
        of_layer = volumes(points, one[layer["name"]])
        assert of_layer.min() > 0.0, layer["name"]
        assert abs(of_layer.sum() / layer["volume_mm3"] - 1.0) < 1e-12, layer["name"]
        count = int((grid.cell_data["material"][0] == number).sum())
        assert count == len(of_layer), layer["name"]
    for name, counts in about["sets"].items():
        nodes = np.unique(one[name]) if name in one else np.array([], int)
        assert len(nodes) == counts["nodes"], name
        assert np.array_equal(np.flatnonzero(grid.point_data[name]), nodes), name
    least = least_dihedral_deg(points, cells)
    assert abs(least - about["least_dihedral_deg"]) < 1e-6
    assert least > LEAST_DIHEDRAL_DEG, least
    off = patch_test(points, cells)
    assert off < 1e-9, off
    print(f"{sensor}: {len(cells)} tetrahedra, least angle {least:.1f} deg, patch test {off:.0e}")


def main(fabkit: str, sensors: list[str]) -> None:
    if sensors:
        for sensor in sensors:
            check(fabkit, sensor, "0.5mm")
        return
    check(fabkit, "rtac0", "2mm")
    check(fabkit, "gelsight-like", "1mm")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
