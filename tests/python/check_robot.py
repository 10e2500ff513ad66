"""Reads what ``fabkit export --robot`` writes with MuJoCo, yourdfpy and trimesh: masses, frames, touch, camera.

    python tests/python/check_robot.py target/release/fabkit [SENSOR...]
"""

import json
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import trimesh
import yourdfpy
from scipy.spatial import ConvexHull

SENSORS = ["rtac0", "shadowtac", "uvdtact", "tactip", "9dtact", "fluidic"]
# Of the meshes that are seen.
CHORD_MM = 0.05
PRESS_MM = 1.0
TACTILE_WITHIN = 0.02
BALL_MM = 4.0


def main(fabkit, sensors):
    for sensor in sensors:
        with tempfile.TemporaryDirectory() as folder:
            options = ["--robot", "urdf,mjcf,sdf", "-o", folder, "--quiet", "--force"]
            subprocess.run([fabkit, "export", sensor, *options], check=True)
            folder = Path(folder)
            document = json.loads((folder / "robot.json").read_text())
            worst = masses(folder, document)
            model = mujoco_reads(folder / f"{sensor}.mjcf.xml", document)
            pieces = cover(folder, document)
            urdf_reads(folder / f"{sensor}.urdf", document)
            sdf_reads(folder / f"{sensor}.sdf", document)
            felt = touched(folder, sensor) if document["taxels"] else None
            told = "" if felt is None else f"; {PRESS_MM:.1f} mm is felt as {felt:.4f} mm"
            print(
                f"{sensor}: {len(document['links'])} links, {1000 * document['mass_kg']:.2f} g, meshes within "
                f"{100 * worst:.3f} %; {pieces} pieces; {model.ngeom} shapes{told}"
            )


def masses(folder, document):
    """Volumes and inertias of the exact solids beside those of the meshes that are seen."""
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
            # A mesh may cut off its chord tolerance, no more.
            off_mm3 = abs(1e9 * mesh.volume - sum(other["volume_mm3"] for other in same))
            assert off_mm3 < CHORD_MM * 1e6 * mesh.area, (body["name"], off_mm3)
        expected = origin_of(link)
        # No more than what meshes may cut off.
        within = cut_kg / link["mass_kg"]
        worst = max(worst, abs(sums[0] / expected[0] - 1))
        np.testing.assert_allclose(sums[0], expected[0], rtol=within)
        # Moments and products about the origin, as a part of the largest.
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
        # No body is heavier about two axes than about the third.
        assert principal[0] > 0 and principal[2] <= principal[0] + principal[1] + 1e-15
    return model


def cover(folder, document):
    """Every corner of what is stiff lies in a piece, but for what meshes cut off."""
    pieces = [trimesh.load(path) for path in sorted(folder.glob("robot-base-[0-9]*.obj"))]
    assert 0 < len(pieces) <= 40 and all(piece.is_convex for piece in pieces)
    # Planes of whole faces: those of slivers among their triangles lean.
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
    # The camera looks at what is touched.
    if "touch_frame" in robot.link_map:
        camera = robot.get_transform("camera_optical")
        touch = robot.get_transform("touch_frame")
        towards = touch[:3, 3] - camera[:3, 3]
        assert camera[:3, 2] @ towards > 0.9 * np.linalg.norm(towards)
    model = mujoco.MjModel.from_xml_path(str(path))
    np.testing.assert_allclose(model.body_subtreemass[0], document["mass_kg"], rtol=1e-6)


def sdf_reads(path, document):
    """No reader of it installs from PyPI alone without a hundred megabytes: what it says is compared here."""
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
    """A ball comes down on the middle, and the vertex there says how far."""
    taxels = np.load(folder / "robot-taxels.npz")
    touch = trimesh.load(folder / "robot-touch.obj", process=False)
    np.testing.assert_allclose(1000 * touch.vertices, taxels["place_mm"], atol=1e-5)
    felt = taxels["area_mm2"] > 0
    assert touch.is_watertight and touch.volume > 0
    # What feels stands for the face alone, without what closes the mesh.
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
    # One number for each vertex along the normal, then two along the surface.
    said = data.sensordata.reshape(3, -1)[0]
    assert len(said) == len(felt)
    reached = 1000 * float(said.max())
    assert abs(reached - PRESS_MM) < TACTILE_WITHIN * PRESS_MM, reached
    near = np.linalg.norm(taxels["place_mm"] - places[top], axis=1) < BALL_MM
    assert not said[~near].any() and np.argmax(said) == np.flatnonzero(felt)[top]
    return reached


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or SENSORS)
