"""Invalid documents and kernels that crash or hang are reported by name, and other jobs continue."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import unittest

from exported import CopiedExports
from fabkit_verify.workers import Limits, run_all


class Failures(CopiedExports):
    def reason(self, change) -> str:
        """Returns the reason that one kernel gives after a change to a tree's text."""
        export = self.export("rtac0", "dowel", "molds.route=printed")
        export.tree_path.write_text(change(export.tree_path.read_text()))
        result = export.verify("manifold3d")
        self.assertEqual(result["verdict"], "failed")
        return result["reason"]

    def changed(self, change) -> str:
        def text(original: str) -> str:
            tree = json.loads(original)
            change(tree)
            return json.dumps(tree)

        return self.reason(text)

    def test_a_truncated_tree(self):
        reason = self.reason(lambda text: text[: len(text) // 2])
        self.assertIn("dowel.tree.json: not JSON, or cut short", reason)
        self.assertIn("dowel.tree.json: not JSON", self.reason(lambda text: ""))

    def test_an_unknown_version_or_format(self):
        reason = self.changed(lambda tree: tree.update(version=99))
        self.assertIn("version 99; this verifier reads 1", reason)
        reason = self.changed(lambda tree: tree.update(format="else"))
        self.assertIn("not a fabkit-tree document", reason)

    def test_an_unknown_primitive(self):
        reason = self.changed(lambda tree: tree.update(solid={"teapot": {"radius_mm": 1.0}}))
        self.assertIn("$.solid: unknown kind `teapot`", reason)

    def test_all_problems_are_said_with_their_places(self):
        ball = {"sphere": {"radius_mm": -1.0}}
        rod = {"cylinder": {"radius_mm": 1.0, "height_mm": float("nan")}}
        mirror = {"rotation": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation_mm": [0, 0, 0]}
        placed = {"placed": {"pose": mirror, "of": {"half-space": {}}}}
        bent = {"start": [1.0, 0.0], "segments": [
            {"arc": {"to": [0.0, 1.1], "centre": [0.0, 0.0], "ccw": True}}]}
        turned = {"revolution": {"profile": {"outer": bent}}}
        union = {"union": [ball, rod, placed, turned, {"union": []}, {"sphere": {}}, 7]}
        reason = self.changed(lambda tree: tree.update(solid=union))
        for words in (
            "$.solid.union[0].sphere.radius_mm is -1.0",
            "$.solid.union[1].cylinder.height_mm is nan",
            "$.solid.union[2].placed.pose.rotation mirrors",
            "$.solid.union[3].revolution.profile.outer.segments[0]: the arc ends 1.1",
            "$.solid.union[4].union must be a list with something in it",
            "$.solid.union[5].sphere must have ['radius_mm']",
            "$.solid.union[6]: a node is an object with one key",
        ):
            self.assertIn(words, reason)

    def test_nesting_without_end(self):
        node = {"sphere": {"radius_mm": 1.0}}
        for _ in range(300):
            node = {"feature": {"name": "again", "of": node}}
        self.assertIn("more than 200 levels", self.changed(lambda tree: tree.update(solid=node)))

    def test_samples_of_another_design(self):
        reason = self.changed(lambda tree: tree.update(design_hash="0"))
        self.assertIn("different designs", reason)

    def test_kernels_that_crash_or_hang_or_throw_are_named(self):
        export = self.export("rtac0", "dowel", "molds.route=printed")
        names = ["crashing", "hanging", "throwing", "leaving"]
        jobs = [export.job(name, f"broken_kernels.{name}") for name in names]
        jobs.insert(2, export.job("manifold3d"))
        told = []
        # A process must have time to start on a busy machine.
        answers = run_all(jobs, Limits(seconds=30.0, processes=2), told.append)
        self.assertEqual(len(told), len(jobs))
        found = {answer["kernel"]: (answer["verdict"], answer["reason"]) for answer in answers}
        self.assertEqual(found["crashing"], ("failed", "the process crashed (SIGSEGV)"))
        self.assertEqual(found["hanging"], ("failed", "took longer than 30 s and was stopped"))
        self.assertEqual(found["throwing"], ("failed", "ZeroDivisionError: on purpose"))
        self.assertEqual(found["leaving"], ("failed", "the process ended with exit code 3"))
        self.assertEqual(found["manifold3d"], ("agrees", ""))

    def test_the_command_answers_and_a_full_disk_loses_only_the_report(self):
        export = self.export("rtac0", "dowel", "molds.route=printed")

        def check(*arguments: str) -> tuple[int, dict]:
            command = [sys.executable, "-m", "fabkit_verify", "check", str(export.folder)]
            run = subprocess.run([*command, *arguments], capture_output=True, check=False)
            return run.returncode, json.loads(run.stdout)

        report = export.folder / "report.html"
        code, document = check("--kernel", "manifold3d", "--report", str(report))
        self.assertEqual((code, document["passed"]), (0, True))
        self.assertIn("Everything agrees", report.read_text())
        if os.path.exists("/dev/full"):
            code, document = check("--kernel", "manifold3d", "--report", "/dev/full")
            self.assertEqual((code, document["passed"]), (1, False))
            self.assertIn("No space left", document["report_error"])
            self.assertEqual(document["results"][0]["verdict"], "agrees")


if __name__ == "__main__":
    unittest.main()
