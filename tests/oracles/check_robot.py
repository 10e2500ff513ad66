"""Checks the files of ``fabkit export --robot`` with MuJoCo, yourdfpy, PyBullet, trimesh, OpenUSD and Drake.

    python tests/oracles/check_robot.py target/release/fabkit [--mounts] [SENSOR...]

It checks masses, frames, touch, tetrahedra, collision pieces, and the pixels of a hundred points in each target's own
projection, for six families and one mount of one sensor, or with `--mounts` for three mounts of all that allow them.
"""

import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import robot_readers as readers
import trimesh
import yourdfpy
from scipy import ndimage
from scipy.spatial import ConvexHull, cKDTree

SENSORS = ["rtac0", "shadowtac", "uvdtact", "tactip", "9dtact", "fluidic"]
MOUNTS = ["iso-9409-1-50-4-m6", "robotiq-2f-85", "franka-hand"]
# Exit code for a design that is not allowed.
REFUSED = 2
FORMATS = "urdf,mjcf,sdf,usd,drake,tacto"
# Chord tolerance of the visual meshes.
CHORD_MM = 0.05
PRESS_MM = 1.0
TACTILE_WITHIN = 0.02
BALL_MM = 4.0
POINTS = 100
POINTS_WITHIN_PX = 0.5
# Largest change between steps from pixel to pixel on one surface; larger ones are edges.
EDGE_PX = 2.0
COVERED_WITHIN_MM = 0.3
# Accuracy of distances to the exact surfaces, which are sampled, mm.
APART_MM = 0.15
SAMPLES_PER_MM2 = 20
OUTER_PER_MM2 = 1


def main(fabkit, words):
    sensors = [word for word in words if not word.startswith("--")] or SENSORS
    for sensor in sensors:
        mounts = MOUNTS if "--mounts" in words else MOUNTS[1:2] if sensor == SENSORS[0] else []
        for mount in ["none", *mounts]:
            with tempfile.TemporaryDirectory() as folder:
                options = ["--robot", FORMATS, "-o", folder, "--quiet", "--force"]
                options += ["--set", f"adapter.pattern={mount}"]
                done = subprocess.run([fabkit, "export", sensor, *options], capture_output=True, text=True)
                if done.returncode == REFUSED and mount != "none":
                    print(f"{sensor}, mount {mount}: refused, {done.stderr.splitlines()[0]}")
                    continue
                assert done.returncode == 0, done.stderr
                measures = mount == "none" or "--mounts" in words
                print(f"{sensor}, mount {mount}: {checked(Path(folder), sensor, measures)}", flush=True)


def checked(folder, sensor, measures):
    """Checks one export; `measures` adds the distance of pieces from bodies, which takes half of the time."""
    document = json.loads((folder / "robot.json").read_text())
    worst = masses(folder, document)
    model = mujoco_reads(folder / f"{sensor}.mjcf.xml", document)
    pieces = cover(folder, document)
    urdf_reads(folder / f"{sensor}.urdf", document)
    sdf_reads(folder / f"{sensor}.sdf", document)
    readers.usd_reads(folder / f"{sensor}.usda", document)
    readers.schemas_hold(folder, sensor, document)
    readers.bullet_reads(folder / f"{sensor}.urdf", document)
    for end in ["urdf", "drake.sdf"]:
        shapes = readers.drake_reads(folder / f"{sensor}.{end}", document)
        assert shapes == model.ngeom, shapes
    told = [
        f"{len(document['links'])} links, {1000 * document['mass_kg']:.2f} g",
        f"meshes within {100 * worst:.3f} %",
        f"{pieces} pieces" + (f", {stands_off(folder, document)}" if measures else ""),
    ]
    if document["taxels"]:
        readers.tetrahedra_read(folder, document)
        told.append(f"{PRESS_MM:.1f} mm is felt as {touched(folder, sensor):.4f} mm")
        told.append(f"{document['soft']['tetrahedra']} tetrahedra")
        told.append(f"points within {camera_sees(folder, sensor, document):.3f} px")
    return "; ".join(told)


def camera_sees(folder, sensor, document):
    """Compares points of the touched surface: their pixel via `pinhole_px` with each target's own projection, px."""
    taxels = np.load(folder / "robot-taxels.npz")
    rays = np.load(folder / "robot-rays.npz")["pinhole_px"]
    known = np.flatnonzero((taxels["seen"] > 0) & (taxels["area_mm2"] > 0))
    columns, rows = taxels["pixel"][known].T
    # Linear between the four nearest pixels; NaN outside the pinhole's image or the lens's field of view.
    ours = np.stack(
        [ndimage.map_coordinates(rays[..., k], [rows, columns], order=1, cval=np.nan) for k in (0, 1)], axis=-1
    )
    # Leave out pixels at an edge of an occluding body: interpolation across it has no meaning.
    row, column = (np.clip(at.astype(int), 1, size - 3) for at, size in zip((rows, columns), rays.shape))
    steps = [rays[row + i, column + j] - rays[row + i, column + j - 1] for i in (0, 1) for j in (0, 1, 2)]
    steps += [rays[row + i, column + j] - rays[row + i - 1, column + j] for i in (0, 1, 2) for j in (0, 1)]
    uneven = np.ptp(steps[:6], axis=0).max(axis=1) + np.ptp(steps[6:], axis=0).max(axis=1)
    inside = np.isfinite(ours).all(axis=1) & (uneven < EDGE_PX)
    assert inside.mean() > 0.8, inside.mean()
    chosen = np.random.default_rng(0).choice(np.flatnonzero(inside), min(POINTS, inside.sum()), replace=False)
    places = taxels["place_mm"][known][chosen] / 1000
    worst = 0.0
    for target, project in readers.projections(folder, sensor, document):
        off = np.abs(project(places) - ours[chosen]).max()
        assert off < POINTS_WITHIN_PX, (target, off)
        worst = max(worst, off)
    return worst


def stands_off(folder, document):
    """Measures the distance of the pieces' outside from the bodies, in words; convex pieces fill hollows."""
    rng = np.random.default_rng(0)
    drawn = {body["name"] for body in document["bodies"] if not body["bends_aside"]}
    meshes = [trimesh.load(folder / f"robot-{name}.obj", process=False) for name in sorted(drawn)]
    exact = cKDTree(np.concatenate([samples(mesh, SAMPLES_PER_MM2, rng) for mesh in meshes]))
    pieces = [trimesh.load(path) for path in sorted(folder.glob("robot-base-[0-9]*.obj"))]
    solid = [ConvexHull(1000 * piece.vertices).equations for piece in pieces]
    if document["taxels"]:
        solid.append(ConvexHull(1000 * trimesh.load(folder / "robot-touch.obj").vertices).equations)
    off = []
    for own, piece in enumerate(pieces):
        places = samples(piece, OUTER_PER_MM2, rng)
        hidden = np.zeros(len(places), dtype=bool)
        for other, faces in enumerate(solid):
            if other != own:
                hidden |= (places @ faces[:, :3].T + faces[:, 3]).max(axis=1) < 1e-3
        off.append(exact.query(places[~hidden])[0])
    off = np.concatenate(off)
    near = np.mean(off < COVERED_WITHIN_MM + APART_MM)
    return f"{100 * near:.1f} % of their outside within {COVERED_WITHIN_MM} mm, at most {off.max():.1f} mm off"


def samples(mesh, per_mm2, rng):
    """Samples points uniformly on a mesh in metres; returns mm."""
    areas = 1e6 * mesh.area_faces
    count = int(per_mm2 * areas.sum()) + 10
    corners = 1000 * mesh.triangles[rng.choice(len(areas), count, p=areas / areas.sum())]
    u, v = rng.random((2, count, 1))
    root = np.sqrt(u)
    return (1 - root) * corners[:, 0] + root * (1 - v) * corners[:, 1] + root * v * corners[:, 2]


def masses(folder, document):
    """Compares volumes and inertias of the exact solids with those of the visual meshes."""
    worst = 0.0
    for link in document["links"]:
        sums, cut_kg = np.zeros(10), 0.0
        for body in document["bodies"]:
            if body["link"] != link["name"] or body.get("counted"):
                continue
            same = [other for other in document["bodies"] if other["name"] == body["name"]]
            for other in same:
                other["counted"] = True
            mesh = trimesh.load(folder / f"robot-{body['name']}.obj", process=False)
            assert mesh.is_watertight or len(same) > 1, body["name"]
            density = 1000 * body["density_g_per_cm3"]
            inertia = about_origin(mesh, density)
            sums += inertia
            cut_kg += density * 1e-3 * CHORD_MM * mesh.area
            # A mesh may be smaller by its chord tolerance over its area, not more.
            off_mm3 = abs(1e9 * mesh.volume - sum(other["volume_mm3"] for other in same))
            assert off_mm3 < CHORD_MM * 1e6 * mesh.area, (body["name"], off_mm3)
        expected = origin_of(link)
        # Relative mass that the chord tolerance may remove.
        within = cut_kg / link["mass_kg"]
        worst = max(worst, abs(sums[0] / expected[0] - 1))
        np.testing.assert_allclose(sums[0], expected[0], rtol=within)
        # Moments and products of inertia about the origin, relative to the largest.
        np.testing.assert_allclose(sums[4:], expected[4:], atol=within * expected[4:].max())
    return worst


def about_origin(mesh, density):
    mass = density * mesh.volume
    centre = mesh.center_mass
    tensor = density * mesh.moment_inertia
    return ten(mass, centre, tensor)


def origin_of(link):
    return ten(link["mass_kg"], np.array(link["centre_m"]), np.array(link["inertia_kg_m2"]))


def ten(mass, centre, tensor):
    """Returns the ten inertial parameters about the origin: mass, first moments, inertia."""
    shifted = tensor + mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    return np.array([mass, *(mass * centre), *shifted[np.triu_indices(3)]])


def mujoco_reads(path, document):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    for _ in range(20):
        mujoco.mj_step(model, data)
    assert not any(warning.number for warning in data.warning)
    np.testing.assert_allclose(model.body_subtreemass[0], document["mass_kg"], rtol=1e-6)
    for link in document["links"]:
        body = model.body(link["name"])
        np.testing.assert_allclose(body.ipos, link["centre_m"], atol=1e-9)
        principal = np.sort(np.linalg.eigvalsh(link["inertia_kg_m2"]))
        np.testing.assert_allclose(np.sort(body.inertia), principal, rtol=1e-6)
        # The principal moments of a real body obey the triangle inequality.
        assert principal[0] > 0 and principal[2] <= principal[0] + principal[1] + 1e-15
    return model


def cover(folder, document):
    """Checks that every vertex of the rigid bodies lies in a convex piece; returns the number of pieces."""
    pieces = [trimesh.load(path) for path in sorted(folder.glob("robot-base-[0-9]*.obj"))]
    assert 0 < len(pieces) <= 40 and all(piece.is_convex for piece in pieces)
    # The convex hull merges triangles of a face: planes of slivers would be inaccurate.
    planes = [ConvexHull(piece.vertices).equations for piece in pieces]
    soft = {link["name"] for link in document["links"][1:]}
    for body in document["bodies"]:
        if body["name"] in soft or body["bends_aside"]:
            continue
        mesh = trimesh.load(folder / f"robot-{body['name']}.obj", process=False)
        inside = np.zeros(len(mesh.vertices), dtype=bool)
        for faces in planes:
            inside |= (mesh.vertices @ faces[:, :3].T + faces[:, 3]).max(axis=1) < 1e-6
        assert inside.all(), body["name"]
    return len(pieces)


def urdf_reads(path, document):
    robot = yourdfpy.URDF.load(str(path), load_collision_meshes=True)
    for link in document["links"]:
        inertial = robot.link_map[link["name"]].inertial
        np.testing.assert_allclose(inertial.mass, link["mass_kg"], rtol=1e-6)
        np.testing.assert_allclose(inertial.origin[:3, 3], link["centre_m"], atol=1e-9)
        np.testing.assert_allclose(inertial.inertia, link["inertia_kg_m2"], rtol=1e-6, atol=1e-18)
    # The camera looks at the touched surface.
    if "touch_frame" in robot.link_map:
        camera = robot.get_transform("camera_optical")
        touch = robot.get_transform("touch_frame")
        towards = touch[:3, 3] - camera[:3, 3]
        assert camera[:3, 2] @ towards > 0.9 * np.linalg.norm(towards)
    model = mujoco.MjModel.from_xml_path(str(path))
    np.testing.assert_allclose(model.body_subtreemass[0], document["mass_kg"], rtol=1e-6)


def sdf_reads(path, document):
    """Checks the elements of SDF that Gazebo reads; Drake's reader uses others."""
    model = ET.parse(path).getroot().find("model")
    links = {link.get("name"): link for link in model.findall("link")}
    for link in document["links"]:
        inertial = links[link["name"]].find("inertial")
        np.testing.assert_allclose(float(inertial.find("mass").text), link["mass_kg"], rtol=1e-6)
        tensor = np.array(link["inertia_kg_m2"])
        for (i, j), name in zip(zip(*np.triu_indices(3)), ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]):
            said = float(inertial.find("inertia").find(name).text)
            np.testing.assert_allclose(said, tensor[i, j], rtol=1e-6, atol=1e-18)
    for uri in model.iter("uri"):
        assert (path.parent / uri.text).is_file(), uri.text


def touched(folder, sensor):
    """Presses a ball into the middle in MuJoCo and checks the indentation at the vertex there; returns it, mm."""
    taxels = np.load(folder / "robot-taxels.npz")
    touch = trimesh.load(folder / "robot-touch.obj", process=False)
    np.testing.assert_allclose(1000 * touch.vertices, taxels["place_mm"], atol=1e-5)
    felt = taxels["area_mm2"] > 0
    assert touch.is_watertight and touch.volume > 0
    # Only the touched face has areas and tangents, not the triangles that close the mesh.
    tangents = np.einsum("vij,vkj->vik", taxels["tangents"], taxels["tangents"])
    np.testing.assert_allclose(tangents, np.broadcast_to(np.eye(2), tangents.shape), atol=1e-9)
    places, normals = taxels["place_mm"][felt], taxels["normal"][felt]
    top = int(np.argmax(places[:, 2] - 1e-3 * np.hypot(places[:, 0], places[:, 1])))
    spec = mujoco.MjSpec.from_file(str(folder / f"{sensor}.mjcf.xml"))
    spec.option.gravity = [0, 0, 0]
    centre = (places[top] + (BALL_MM - PRESS_MM) * normals[top]) / 1000
    ball = spec.worldbody.add_body(name="ball", pos=centre)
    ball.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[BALL_MM / 1000, 0, 0], mass=0.01)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    # The sensor gives one number for each vertex along the normal, then two along the surface.
    said = data.sensordata.reshape(3, -1)[0]
    assert len(said) == len(felt)
    reached = 1000 * float(said.max())
    assert abs(reached - PRESS_MM) < TACTILE_WITHIN * PRESS_MM, reached
    near = np.linalg.norm(taxels["place_mm"] - places[top], axis=1) < BALL_MM
    assert not said[~near].any() and np.argmax(said) == np.flatnonzero(felt)[top]
    return reached


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
