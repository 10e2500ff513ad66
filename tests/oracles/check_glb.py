"""Checks the files of `fabkit export --format glb` with trimesh, and with gltf-validator if given.

    python check_glb.py PATH_TO_FABKIT [--validator NODE_MODULES] [DESIGN ...]

By default it checks every built-in sensor and its fixtures. trimesh must find every body of the assembly by name,
below one node per body and once for each placement: closed, with the volume that the body's own files state, and at
the pose in the body's tree, rotated to y up and in metres. The animation must move only these nodes, each from its
pose. Normals must be unit vectors on the side of their triangles. Khronos' validator, from a folder with the npm
package `gltf-validator`, must report nothing.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import trimesh

METRES_PER_MM = 1e-3
# Rounding of f32 coordinates and of the pose's digits, mm.
SLACK_MM = 2e-5

VALIDATE = """
const validator = require("gltf-validator");
const bytes = new Uint8Array(require("fs").readFileSync(process.argv[1]));
validator.validateBytes(bytes).then(report => console.log(JSON.stringify(report.issues)));
"""


def fabkit(binary: str, *arguments: str) -> dict:
    done = subprocess.run([binary, "--json", *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"fabkit {' '.join(arguments)}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return json.loads(done.stdout)


def validate(path: Path, node_modules: str) -> None:
    """Checks that Khronos' validator reports no errors, warnings, notes or hints."""
    done = subprocess.run(
        ["node", "-e", VALIDATE, str(path)],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "NODE_PATH": node_modules},
    )
    issues = json.loads(done.stdout)
    assert not issues["messages"], f"{path.name}: {issues['messages'][:5]}"


def parts_of(path: Path) -> tuple[dict, bytes]:
    """Returns the two chunks of a GLB file: the JSON and the bytes."""
    content = path.read_bytes()
    length = int.from_bytes(content[12:16], "little")
    return json.loads(content[20 : 20 + length]), content[28 + length :]


def vectors(document: dict, content: bytes, accessor: int) -> numpy.ndarray:
    entry = document["accessors"][accessor]
    view = document["bufferViews"][entry["bufferView"]]
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    return numpy.frombuffer(content, "<f4", 3 * entry["count"], start).reshape(-1, 3)


def matrix_of(pose: dict) -> numpy.ndarray:
    matrix = numpy.eye(4)
    matrix[:3, :3] = pose["rotation"]
    matrix[:3, 3] = pose["translation_mm"]
    return matrix


def moves_of(document: dict, content: bytes) -> dict[str, numpy.ndarray]:
    """Returns the displacement of each node by the animation, in the root node's frame, mm."""
    (animation,) = document.get("animations", [{"channels": [], "name": "explode"}])
    assert animation["name"] == "explode", animation["name"]
    found = {}
    for channel in animation["channels"]:
        target = channel["target"]
        assert target["path"] == "translation", target
        node = document["nodes"][target["node"]]
        output = animation["samplers"][channel["sampler"]]["output"]
        before, after = vectors(document, content, output).astype(float)
        place = node.get("translation", [0, 0, 0])
        assert numpy.abs(before - place).max() < SLACK_MM, f"{node['name']} jumps"
        found[node["name"]] = after - before
    return found


def check_normals(name: str, mesh: trimesh.Trimesh) -> None:
    lengths = numpy.linalg.norm(mesh.vertex_normals, axis=1)
    assert numpy.abs(lengths - 1).max() < 1e-4, f"{name}: normals of length {lengths.min()}"
    flat = numpy.cross(*(mesh.triangles[:, i] - mesh.triangles[:, 0] for i in (1, 2)))
    area = numpy.linalg.norm(flat, axis=1) / 2
    along = numpy.einsum("ijk,ik->ij", mesh.vertex_normals[mesh.faces], flat) / (2 * area[:, None])
    # Slivers may have any normal; weighting by area ignores them.
    turned = area[(along < 0.5).any(axis=1)].sum() / area.sum()
    assert turned < 1e-3, f"{name}: {turned:.1e} of its area has normals of another side"


def check(binary: str, design: str, folder: Path, node_modules: str | None) -> None:
    shown = fabkit(binary, "show", design)
    standing = [body for body in shown["bodies"] if body["assemblies"]]
    assemblies = [assembly for body in standing for assembly in body["assemblies"]]
    assembly = "sensor" if "sensor" in assemblies else assemblies[0]
    names = [body["name"] for body in standing if assembly in body["assemblies"]]
    chosen = [f"--part={name}" for name in names]
    formats = "--format=glb,tree"
    exported = fabkit(binary, "export", design, formats, "-o", str(folder), "--nominal", *chosen)
    manifest = exported["manifest"]
    trees = {name: json.loads((folder / f"{name}.tree.json").read_text()) for name in names}
    volumes = {part["name"]: part["mesh"]["volume_mm3"] for part in manifest["parts"]}

    (entry,) = [file for file in manifest["files"] if file["format"] == "glb"]
    assert entry["name"] == f"{shown['name']}.glb" and entry["parts"] == names, entry
    path = folder / entry["name"]
    if node_modules:
        validate(path, node_modules)
    document, content = parts_of(path)
    scene = trimesh.load_scene(path, process=False)
    assert list(scene.geometry) == names, f"{design}: {list(scene.geometry)}"
    root, moves = document["nodes"][0], moves_of(document, content)
    turned, _ = scene.graph.get(root["name"])
    assert numpy.abs(turned @ turned.T - METRES_PER_MM**2 * numpy.eye(4))[:3, :3].max() < 1e-15
    if assembly == "sensor":
        assert numpy.abs(turned[:3, :3] @ [0, 0, 1] - [0, METRES_PER_MM, 0]).max() < 1e-12

    below = {document["nodes"][child]["name"]: document["nodes"][child] for child in root["children"]}
    assert list(below) == names, f"{design}: {list(below)}"
    for name in names:
        tree = trees[name]
        check_body(name, below[name], tree, volumes[name], scene.geometry[name])
        places = [p for p in tree["placements"] if p["assembly"] == assembly]
        nodes = [name] if len(places) == 1 else [f"{name} {i + 1}" for i in range(len(places))]
        for node, place in zip(nodes, places, strict=True):
            found, geometry = scene.graph.get(node)
            assert geometry == name, f"{node} shows {geometry}"
            expected = turned @ matrix_of(place["assembly_from_body"])
            off = numpy.abs(found - expected)
            assert off[:3, :3].max() < 1e-12 and off[:3, 3].max() < 1e-3 * SLACK_MM, f"{node}: {off}"
            moves.pop(node, None)
    assert not moves, f"{design}: {moves} move too"
    print(f"{design}: {len(names)} bodies, {path.stat().st_size / 1e6:.2f} MB")


def check_body(name: str, node: dict, tree: dict, volume_mm3: float, mesh: trimesh.Trimesh) -> None:
    check_normals(name, mesh)
    merged = mesh.copy()
    merged.merge_vertices(merge_norm=True, merge_tex=True, digits_vertex=9)
    assert merged.is_watertight, f"{name} is open"
    for found in (merged.volume, node["extras"]["volume_mm3"]):
        assert abs(found - volume_mm3) < 1e-3 * volume_mm3 + 1e-3, f"{name}: {found}, not {volume_mm3}"
    for key in ("kind", "summary", "quantity"):
        assert node["extras"][key] == tree[key], f"{name}: {node['extras'][key]}"
    assert node["extras"].get("material", "") == tree["material"], name
    alpha = mesh.visual.material.baseColorFactor[3] / 255
    assert abs(alpha - tree["opacity"]) < 0.01, f"{name}: alpha {alpha}, not {tree['opacity']}"


def main() -> None:
    arguments = argparse.ArgumentParser()
    arguments.add_argument("fabkit")
    arguments.add_argument("designs", nargs="*")
    arguments.add_argument("--validator")
    asked = arguments.parse_args()
    listed = fabkit(asked.fabkit, "list")["sensors"]
    all_designs = [
        "/".join(path) for s in listed for path in [(s["name"],), *((s["name"], f) for f in s["fixtures"])]
    ]
    with tempfile.TemporaryDirectory() as folder:
        for design in asked.designs or all_designs:
            check(asked.fabkit, design, Path(folder) / design.replace("/", "-"), asked.validator)


if __name__ == "__main__":
    main()
