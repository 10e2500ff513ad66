"""Exports of `fabkit export`, made once for all tests, and helpers to change them."""

from __future__ import annotations

import functools
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy

from fabkit_verify.job import Job, jobs

FABKIT = os.environ["FABKIT"]

STL_TRIANGLE = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@functools.cache
def _exported(sensor: str, part: str, changes: tuple[str, ...]) -> tempfile.TemporaryDirectory:
    folder = tempfile.TemporaryDirectory(prefix="fabkit-test-")
    overrides = [word for change in changes for word in ("--set", change)]
    command = [FABKIT, "export", sensor, "--quiet", "--nominal", "--part", part]
    command += ["--format", "stl,tree,samples", "-o", folder.name, *overrides]
    subprocess.run(command, check=True)
    return folder


class Export:
    """A copy of one exported part that a test may modify."""

    def __init__(self, folder: Path, sensor: str, part: str, *changes: str):
        self.folder, self.part = folder, part
        source = _exported(sensor, part, changes).name
        shutil.copytree(source, folder, dirs_exist_ok=True)

    @property
    def tree_path(self) -> Path:
        return self.folder / f"{self.part}.tree.json"

    def tree(self) -> dict[str, Any]:
        return json.loads(self.tree_path.read_text())

    def write_tree(self, tree: dict[str, Any]) -> None:
        self.tree_path.write_text(json.dumps(tree))

    def triangles(self) -> numpy.ndarray:
        content = (self.folder / f"{self.part}.stl").read_bytes()
        return numpy.frombuffer(content, STL_TRIANGLE, offset=84).copy()

    def write_triangles(self, triangles: numpy.ndarray) -> None:
        header = bytes(80) + numpy.uint32(len(triangles)).tobytes()
        (self.folder / f"{self.part}.stl").write_bytes(header + triangles.tobytes())

    def verify(self, kernel: str) -> dict[str, Any]:
        return self.job(kernel).run()

    def job(self, kernel: str, module: str | None = None) -> Job:
        (job,) = jobs(self.folder, [self.part], [kernel])
        return job if module is None else Job(self.folder, self.part, kernel, module)


class CopiedExports(unittest.TestCase):
    """Base class of tests that modify exports."""

    def export(self, sensor: str, part: str, *changes: str) -> Export:
        folder = tempfile.TemporaryDirectory(prefix="fabkit-test-")
        self.addCleanup(folder.cleanup)
        return Export(Path(folder.name), sensor, part, *changes)


def nodes(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yields a node and all nodes below it."""
    yield node
    ((kind, of),) = node.items()
    if kind in ("union", "intersection"):
        for child in of:
            yield from nodes(child)
    elif kind == "difference":
        for child in [of["of"], *of["minus"]]:
            yield from nodes(child)
    elif kind in ("placed", "feature"):
        yield from nodes(of["of"])


def feature(tree: dict[str, Any], name: str) -> dict[str, Any]:
    """Returns the node below the feature of a name."""
    for node in nodes(tree["solid"]):
        if node.get("feature", {}).get("name") == name:
            return node["feature"]
    raise KeyError(name)


def mirrored(node: dict[str, Any]) -> dict[str, Any]:
    """Mirrors a solid across x; all primitives except extrusions are symmetric."""
    ((kind, of),) = node.items()
    match kind:
        case "union" | "intersection":
            return {kind: [mirrored(child) for child in of]}
        case "difference":
            minus = [mirrored(tool) for tool in of["minus"]]
            return {kind: {"of": mirrored(of["of"]), "minus": minus}}
        case "feature":
            return {kind: {**of, "of": mirrored(of["of"])}}
        case "placed":
            flip = numpy.diag([-1.0, 1.0, 1.0])
            rotation = flip @ numpy.array(of["pose"]["rotation"]) @ flip
            shift = flip @ numpy.array(of["pose"]["translation_mm"])
            pose = {"rotation": rotation.tolist(), "translation_mm": shift.tolist()}
            return {kind: {"pose": pose, "of": mirrored(of["of"])}}
        case "extrusion":
            return {kind: {**of, "profile": _mirrored_profile(of["profile"])}}
        case _:
            return node


def _mirrored_profile(profile: dict[str, Any]) -> dict[str, Any]:
    def path(of):
        segments = []
        for segment in of["segments"]:
            ((kind, how),) = segment.items()
            points = {k: [-how[k][0], how[k][1]] for k in ("to", "centre") if k in how}
            turn = {"ccw": not how["ccw"]} if "ccw" in how else {}
            segments.append({kind: {**how, **points, **turn}})
        return {"start": [-of["start"][0], of["start"][1]], "segments": segments}

    holes = [path(hole) for hole in profile.get("holes", [])]
    return {"outer": path(profile["outer"]), "holes": holes}
