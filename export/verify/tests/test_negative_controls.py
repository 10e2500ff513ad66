"""Negative controls: the verifier must detect each deliberate fault and name it."""

from __future__ import annotations

import unittest

import numpy
from exported import CopiedExports, feature, mirrored, nodes

REBUILDING = ("cadquery", "build123d", "manifold3d")
EXACT = ("cadquery", "build123d")


class NegativeControls(CopiedExports):
    def assert_caught(self, result: dict, *words: str) -> None:
        self.assertEqual(result["verdict"], "differs", result["reason"] or result["kernel"])
        for word in words:
            self.assertIn(word, result["reason"])

    def test_without_a_fault_everything_agrees(self):
        parts = [("rtac0", "base"), ("shadowtac", "skin", "dimples.rings=2")]
        parts += [("rtac0", "silicone-mold-transparent-gel"), ("rtac0", "diffuser")]
        for chosen in parts:
            export = self.export(*chosen)
            for kernel in (*REBUILDING, "trimesh"):
                result = export.verify(kernel)
                self.assertEqual((kernel, result["verdict"], result["reason"]), (kernel, "agrees", ""))
                self.assertGreaterEqual(len(result["checks"]), 10)

    def test_a_hole_moved_by_20_um(self):
        export = self.export("rtac0", "base", "labels.style=none")
        tree = export.tree()
        pose = feature(tree, "camera screw hole 2")["of"]["placed"]["pose"]
        pose["translation_mm"][0] += 0.020
        export.write_tree(tree)
        for kernel in REBUILDING:
            self.assert_caught(export.verify(kernel), "distance 0.0", "camera screw hole 2")

    def test_a_missing_dimple(self):
        export = self.export("shadowtac", "skin", "dimples.rings=2")
        tree = export.tree()
        cut = next(node["difference"] for node in nodes(tree["solid"]) if "difference" in node)
        missing = next(tool for tool in cut["minus"] if tool["feature"]["name"].endswith(" 7"))
        cut["minus"].remove(missing)
        export.write_tree(tree)
        for kernel in REBUILDING:
            self.assert_caught(export.verify(kernel), missing["feature"]["name"])

    def test_a_sphere_with_5_um_more_radius(self):
        export = self.export("rtac0", "silicone-mold-transparent-gel")
        tree = export.tree()
        (turned,) = (node["revolution"] for node in nodes(tree["solid"]) if "revolution" in node)
        (rim, dome) = turned["profile"]["outer"]["segments"][1:3]
        self.assertEqual((rim["line"]["to"], dome["arc"]["centre"]), ([13.5, 6.0], [0.0, 6.0]))
        rim["line"]["to"][0] += 0.005
        dome["arc"]["to"][1] += 0.005
        export.write_tree(tree)
        for kernel in EXACT:
            self.assert_caught(export.verify(kernel), "distance 0.00", "volume", "cavity")

    def test_a_mirrored_part(self):
        export = self.export("rtac0", "base", "labels.style=none")
        tree = export.tree()
        tree["solid"] = mirrored(tree["solid"])
        export.write_tree(tree)
        for kernel in REBUILDING:
            self.assert_caught(export.verify(kernel), "distance")
        triangles = export.triangles()
        corners = triangles["corners"]
        corners[:, :, 0] = corners[:, :, 0].max() - corners[:, :, 0]
        triangles["corners"] = corners[:, ::-1]
        export.write_triangles(triangles)
        self.assert_caught(export.verify("trimesh"), "distance")

    def test_a_flipped_facet(self):
        export = self.export("rtac0", "diffuser")
        triangles = export.triangles()
        triangles["corners"][10] = triangles["corners"][10][::-1].copy()
        export.write_triangles(triangles)
        self.assert_caught(export.verify("trimesh"), "neighbouring triangles face different ways")

    def test_a_facet_that_is_not_there(self):
        export = self.export("rtac0", "diffuser")
        export.write_triangles(numpy.delete(export.triangles(), 10))
        self.assert_caught(export.verify("trimesh"), "the mesh is not closed")

    def test_two_overlapping_shells(self):
        export = self.export("rtac0", "diffuser")
        triangles = export.triangles()
        again = triangles.copy()
        again["corners"] *= 0.5
        export.write_triangles(numpy.concatenate([triangles, again]))
        self.assert_caught(export.verify("trimesh"), "shells: trimesh finds 2, fabkit says 1")


if __name__ == "__main__":
    unittest.main()
