"""Exact ground truth beside ray casting of meshes: speed and error on the same scene.

Run by `cargo xtask bench-depth`; by hand:

    python against_embree.py path/to/fabkit OURS_MRAY_PER_CPU_SECOND

The scene: R-Tac0's surface with the protrusions of five semi-domes, the same rays for all. Meshes
are what fabkit exports at a chord tolerance, and a dome of rings at the same tolerance. Embree
casts in 32-bit; which triangle it finds is also intersected in 64-bit, which tells the mesh's error
from the arithmetic's.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh

SEMI_DOMES = [f"semi-dome-{number:03}" for number in (3, 17, 29, 58, 91)]
RADIUS_MM, CENTRE_Z_MM, CAMERA_Z_MM = 15.0, 6.0, -7.0
PERCENTILES = (50, 90, 99, 99.9, 100)


def dome(tolerance_mm):
    """The hemisphere and its wall as a mesh whose vertices lie on them."""
    step = 2 * np.arccos(1 - tolerance_mm / RADIUS_MM)
    rings = int(np.ceil(np.pi / 2 / step)) + 1
    polar = np.linspace(1e-9, np.pi / 2, rings)
    r = np.append(RADIUS_MM * np.sin(polar), RADIUS_MM)
    z = np.append(CENTRE_Z_MM + RADIUS_MM * np.cos(polar), 0)
    around = int(np.ceil(2 * np.pi / step))
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)
    points = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)),
                       np.repeat(z[:, None], around, 1)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(len(r) - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = a + around, b + around
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([b, d, c], -1)]).reshape(-1, 3)
    return trimesh.Trimesh(points, faces, process=False)


def scene(fabkit, folder, tolerance_mm):
    folder = folder / f"{tolerance_mm}"
    parts = [word for name in SEMI_DOMES for word in ("--part", name)]
    subprocess.run([fabkit, "export", "rtac0/semi-domes", "-o", folder, "--format", "stl", "--nominal",
                    "--tolerance", f"{tolerance_mm}mm", "--quiet", *parts], check=True)
    meshes = [trimesh.load(folder / f"{name}.stl", process=False) for name in SEMI_DOMES]
    for mesh in meshes:
        # Files lie as they are printed: on their backs, in the corner of the bed. In the sensor the
        # seam's face is at x = -0.1, the flange's underside at z = 0.3, and y is centred.
        x, y, z = mesh.vertices[:, 2], mesh.vertices[:, 1], -mesh.vertices[:, 0]
        x, y, z = x - x.max() - 0.1, y - (y.min() + y.max()) / 2, z - z.min() + 0.3
        mesh.vertices = np.stack([x, y, z], -1)
    return trimesh.util.concatenate([dome(tolerance_mm), *meshes])


def in_64_bit(mesh, triangle, directions, origin):
    """Range of each ray to the plane of its triangle."""
    a = mesh.vertices[mesh.faces[triangle, 0]]
    ab = mesh.vertices[mesh.faces[triangle, 1]] - a
    ac = mesh.vertices[mesh.faces[triangle, 2]] - a
    normal = np.cross(ab, ac)
    return np.einsum("ij,ij->i", normal, a - origin) / np.einsum("ij,ij->i", normal, directions)


def embree(mesh, origins, directions):
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, mesh.triangles.astype(np.float32))
    start = time.process_time()
    triangle = scene.run(origins.astype(np.float32), directions.astype(np.float32))
    seconds = time.process_time() - start
    distance = scene.run(origins.astype(np.float32), directions.astype(np.float32), query="DISTANCE")
    return triangle, distance.astype(float), seconds


def open3d_cast(mesh, origins, directions):
    try:
        import open3d as o3d
    except ImportError:
        return None
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    vertices = o3d.core.Tensor(mesh.vertices.astype(np.float32))
    scene.add_triangles(vertices, o3d.core.Tensor(mesh.faces.astype(np.uint32)))
    rays = o3d.core.Tensor(np.concatenate([origins, directions], 1).astype(np.float32))
    start = time.process_time()
    distance = scene.cast_rays(rays, nthreads=1)["t_hit"].numpy()
    return distance.astype(float), time.process_time() - start


def row(name, mray, error_mm, missed):
    shown = "  ".join(f"{np.percentile(error_mm, p) * 1000:8.2f}" for p in PERCENTILES)
    rate = f"{mray:7.2f}" if mray else "       "
    print(f"{name:34} {rate}  {shown}  {missed:6}")


def main(fabkit, ours_mray):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        presses = [word for name in SEMI_DOMES for word in ("--press", name)]
        subprocess.run([fabkit, "depth", "rtac0", "-o", folder / "truth.npz", "--quiet", *presses],
                       check=True)
        truth = np.load(folder / "truth.npz")
        seen = np.isfinite(truth["range_mm"]).ravel()
        exact = truth["range_mm"].ravel()[seen]
        origin = np.array([0.0, 0.0, CAMERA_Z_MM])
        directions = truth["point_in_sensor"].reshape(-1, 3)[seen] - origin
        directions /= exact[:, None]
        origins = np.broadcast_to(origin, directions.shape)
        count = int(truth["contact"].sum())
        print(f"{seen.sum()} rays, {count} of them to protrusions; errors in um\n")
        heads = "  ".join(f"{p:7}%" for p in PERCENTILES)
        print(f"{'':34} Mray/CPU-s {heads[3:]}  missed")
        row("fabkit, exact (reference of all)", ours_mray, np.zeros(1), 0)
        rates = {}
        for tolerance_mm in (0.01, 0.001):
            mesh = scene(fabkit, folder, tolerance_mm)
            print(f"mesh at {tolerance_mm} mm: {len(mesh.faces)} triangles")
            triangle, distance, seconds = embree(mesh, origins, directions)
            hit = triangle >= 0
            rates[tolerance_mm] = len(exact) / seconds / 1e6
            row("  embreex, 32-bit", rates[tolerance_mm], abs(distance - exact)[hit], (~hit).sum())
            refined = in_64_bit(mesh, triangle[hit], directions[hit], origin)
            error = abs(refined - exact[hit])
            row("  its triangles in 64-bit", None, error, 0)
            # Away from creases a chord's error is seen enlarged by the incidence alone; along and
            # around the dome it adds up.
            bound = 2 * tolerance_mm / np.cos(truth["incidence_rad"].ravel()[seen][hit])
            beyond = error > 1.01 * bound + 1e-6
            print(f"  beyond the chord's error, which is at creases: {beyond.sum()} rays "
                  f"({100 * beyond.mean():.3f} %)")
            cast = open3d_cast(mesh, origins, directions)
            if cast is None:
                print("  Open3D: not here")
            else:
                distance, seconds = cast
                hit = np.isfinite(distance)
                row("  Open3D, 32-bit", len(exact) / seconds / 1e6, abs(distance - exact)[hit],
                    (~hit).sum())
        if ours_mray:
            print(f"\nfabkit : embreex on the 0.01 mm mesh = {ours_mray / rates[0.01]:.1f}")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]) if len(sys.argv) > 2 else None)
