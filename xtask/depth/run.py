"""Exact ground truth beside ray casting of meshes: speed and error on the same scene.

Run by `cargo xtask bench-depth`; by hand:

    python run.py path/to/fabkit path/to/depth_throughput docs/benchmarks_depth.md

The scene: R-Tac0's surface with the protrusions of five semi-domes, the same rays for all. Meshes
are what fabkit exports at a chord tolerance, and a dome of rings at the same tolerance. Embree and
Open3D cast in 32-bit; which triangle Embree finds is also intersected in 64-bit, which tells the
mesh's error from the arithmetic's.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import trimesh

SEMI_DOMES = [f"semi-dome-{number:03}" for number in (3, 17, 29, 58, 92)]
TOLERANCES_MM = (0.01, 0.001)
RADIUS_MM, CENTRE_Z_MM, CAMERA_Z_MM = 15.0, 6.0, -7.0
PERCENTILES = (50, 90, 99, 99.9, 100)
# CPU time that a rate is measured over, at least, s.
LEAST_SECONDS = 1.0
MARK = "<!-- bench-depth -->"


def dome(tolerance_mm):
    """The hemisphere and its wall as a mesh whose vertices lie on them.

    Along and around the dome chords add up, so that each may take half of the tolerance.
    """
    step = 2 * np.arccos(1 - tolerance_mm / 2 / RADIUS_MM)
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


def mray_per_cpu_s(rays, cast):
    """The rate of a call after one that is not timed, and its result."""
    result, count = cast(), 0
    start = time.process_time()
    while time.process_time() - start < LEAST_SECONDS:
        cast()
        count += 1
    return count * rays / (time.process_time() - start) / 1e6, result


def in_64_bit(mesh, triangle, directions, origin):
    """Range of each ray to the plane of its triangle."""
    a = mesh.vertices[mesh.faces[triangle, 0]]
    ab = mesh.vertices[mesh.faces[triangle, 1]] - a
    ac = mesh.vertices[mesh.faces[triangle, 2]] - a
    normal = np.cross(ab, ac)
    return np.einsum("ij,ij->i", normal, a - origin) / np.einsum("ij,ij->i", normal, directions)


class Scene:
    """What is asked of every caster: rays, their exact ranges, and what they meet."""

    def __init__(self, fabkit, folder):
        presses = [word for name in SEMI_DOMES for word in ("--press", name)]
        file = folder / "truth.npz"
        subprocess.run([fabkit, "depth", "rtac0", "-o", file, "--quiet", *presses], check=True)
        truth = np.load(file)
        seen = np.isfinite(truth["range_mm"]).ravel()
        self.exact_mm = truth["range_mm"].ravel()[seen]
        self.contact = truth["contact"].ravel()[seen]
        self.cosine = np.cos(truth["incidence_rad"].ravel()[seen])
        self.origin = np.array([0.0, 0.0, CAMERA_Z_MM])
        directions = truth["point_in_sensor"].reshape(-1, 3)[seen] - self.origin
        self.directions = directions / self.exact_mm[:, None]
        self.origins = np.tile(self.origin, (len(directions), 1))


def row(name, mesh, rate, ours, error_mm, missed, contact):
    shown = [f"{1000 * np.percentile(error_mm, p):.2f}" for p in PERCENTILES]
    of_contact = [f"{1000 * np.percentile(error_mm[contact], p):.2f}" for p in (50, 99, 100)]
    rate, ratio = (f"{rate:.2f}", f"{ours / rate:.1f}") if rate else ("", "")
    return [name, mesh, rate, ratio, *shown, *of_contact, str(missed)]


def rows_of_mesh(scene, mesh, tolerance_mm, ours, say):
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    label = f"{tolerance_mm} mm, {len(mesh.faces)} triangles"
    origins, directions = scene.origins.astype(np.float32), scene.directions.astype(np.float32)
    count = len(scene.exact_mm)

    embree = rtcore_scene.EmbreeScene()
    TriangleMesh(embree, mesh.triangles.astype(np.float32))
    rate, triangle = mray_per_cpu_s(count, lambda: embree.run(origins, directions))
    distance_mm = embree.run(origins, directions, query="DISTANCE").astype(float)
    hit = triangle >= 0
    error = abs(distance_mm - scene.exact_mm)
    yield row("embreex, 32-bit", label, rate, ours, error[hit], (~hit).sum(), scene.contact[hit])
    refined_mm = in_64_bit(mesh, triangle[hit], scene.directions[hit], scene.origin)
    error = abs(refined_mm - scene.exact_mm[hit])
    yield row("its triangles in 64-bit", label, None, ours, error, (~hit).sum(), scene.contact[hit])
    beyond = error > 1.01 * tolerance_mm / scene.cosine[hit] + 1e-6
    say(f"mesh at {tolerance_mm} mm: {beyond.sum()} of {count} rays are further off than the chord's "
        f"error seen at their incidence; they end at creases and outlines.")

    intersector = RayMeshIntersector(mesh)
    rate, (points, ray, _) = mray_per_cpu_s(count, lambda: intersector.intersects_location(
        scene.origins, scene.directions, multiple_hits=False))
    error = abs(np.linalg.norm(points - scene.origin, axis=1) - scene.exact_mm[ray])
    yield row("trimesh through embreex", label, rate, ours, error, count - len(ray),
              scene.contact[ray])

    try:
        import open3d as o3d
    except ImportError as why:
        say(f"Open3D is not part of this run: {why}.")
        yield ["Open3D: **not run**", label, *[""] * (len(PERCENTILES) + 6)]
        return
    cast = o3d.t.geometry.RaycastingScene(nthreads=1)
    vertices = o3d.core.Tensor(mesh.vertices.astype(np.float32))
    cast.add_triangles(vertices, o3d.core.Tensor(mesh.faces.astype(np.uint32)))
    rays = o3d.core.Tensor(np.concatenate([origins, directions], 1))
    rate, answer = mray_per_cpu_s(count, lambda: cast.cast_rays(rays, nthreads=1))
    distance_mm = answer["t_hit"].numpy().astype(float)
    hit = np.isfinite(distance_mm)
    error = abs(distance_mm - scene.exact_mm)[hit]
    yield row(f"Open3D {o3d.__version__}, 32-bit", label, rate, ours, error, (~hit).sum(),
              scene.contact[hit])


def table(rows):
    heads = ["caster", "scene", "Mray per CPU-s", "fabkit : it",
             *[f"{p} %" for p in PERCENTILES], "contact 50 %", "99 %", "100 %", "missed"]
    lines = [heads, ["---", "---", *["---:"] * (len(heads) - 2)], *rows]
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def main(fabkit, throughput, document):
    said = []
    say = said.append
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        ours = json.loads(subprocess.run([throughput, "rtac0", *SEMI_DOMES], check=True,
                                         capture_output=True).stdout)
        rate = ours["mray_per_cpu_s"]["reference_and_press"]
        target = Scene(fabkit, folder)
        rows = [row("fabkit, 64-bit", f"exact, {ours['pressers']} protrusions", rate, rate,
                    np.zeros_like(target.exact_mm), 0, target.contact)]
        rates = ", ".join(f"{name.replace('_', ' ')} {value:.1f}"
                          for name, value in ours["mray_per_cpu_s"].items())
        say(f"{ours['rays']} rays, of which {len(target.exact_mm)} see the surface and "
            f"{target.contact.sum()} protrusions. fabkit, Mray per CPU-second: {rates}.")
        for tolerance_mm in TOLERANCES_MM:
            mesh = scene(fabkit, folder, tolerance_mm)
            rows.extend(rows_of_mesh(target, mesh, tolerance_mm, rate, say))
    text = table(rows) + "\n" + "".join(f"- {line}\n" for line in said)
    print(text)
    document = Path(document)
    before, _, after = document.read_text().partition(MARK)
    _, _, after = after.partition(MARK)
    document.write_text(f"{before}{MARK}\n{text}{MARK}{after}")


if __name__ == "__main__":
    main(*sys.argv[1:])
