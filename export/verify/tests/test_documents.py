"""Trees of all built-in sensors fit docs/tree.schema.json, and gmsh reads the STEP files."""

from __future__ import annotations

import json
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import gmsh
import jsonschema

from exported import FABKIT, CopiedExports
from fabkit_verify.document import DocumentError, read
from fabkit_verify.step import StepJob

SCHEMA = Path(__file__).parents[3] / "docs" / "tree.schema.json"


class Documents(CopiedExports):
    def setUp(self):
        schema = json.loads(SCHEMA.read_text())
        jsonschema.Draft202012Validator.check_schema(schema)
        self.validator = jsonschema.Draft202012Validator(schema)

    def test_every_tree_fits_the_schema(self):
        listed = subprocess.run([FABKIT, "--json", "list"], check=True, capture_output=True)
        count = 0
        for sensor in json.loads(listed.stdout)["sensors"]:
            parts = [*sensor["parts"], *sensor["layers"], *sensor["components"]]
            chosen = [word for part in parts for word in ("--part", part)]
            with tempfile.TemporaryDirectory() as folder:
                command = [FABKIT, "export", sensor["name"], "--quiet", "--format", "tree"]
                subprocess.run([*command, "-o", folder, *chosen], check=True)
                for path in Path(folder).glob("*.tree.json"):
                    self.validator.validate(read(path))
                    count += 1
        self.assertGreater(count, 100)

    def test_schema_and_reader_refuse_the_same(self):
        export = self.export("rtac0", "dowel", "molds.route=printed")
        rod = {"cylinder": {"radius_mm": 1.0, "height_mm": 2.0}}
        wrong = [
            {"teapot": {}},
            {"cylinder": {"radius_mm": 1.0}},
            {"cylinder": {"radius_mm": -1.0, "height_mm": 2.0}},
            {"cylinder": {"radius_mm": 1.0, "height_mm": 2.0, "colour": 1}},
            {"union": []},
            {"difference": {"of": rod}},
            {**rod, "sphere": {"radius_mm": 1.0}},
            {"extrusion": {"height_mm": 1.0, "profile": {"outer": {"start": [0, 0], "segments": []}}}},
        ]
        tree = export.tree()
        for solid in wrong:
            tree["solid"] = solid
            export.write_tree(tree)
            with self.assertRaises(jsonschema.ValidationError, msg=str(solid)):
                self.validator.validate(tree)
            with self.assertRaises(DocumentError, msg=str(solid)):
                read(export.tree_path)

    def test_gmsh_reads_step_files_with_their_volume(self):
        export = self.export("rtac0", "base", "labels.style=none")
        answer = StepJob(export.folder, export.folder, "base").run()
        self.assertEqual((answer["passed"], answer["reason"]), (True, ""))
        self.assertEqual(answer["faces"], {"cone": 2, "cylinder": 11, "plane": 34})
        text = (export.folder / "base.step").read_text()
        for words in ("PRODUCT('base'", "AP242", "SI_UNIT(.MILLI.,.METRE.)", "COLOUR_RGB"):
            self.assertIn(words, text)
        # Faces carry the names of their features: four holes are one cylinder each.
        names = re.findall(r"ADVANCED_FACE\('([^']*)'", text)
        self.assertEqual(len(names), 47)
        for hole in range(1, 5):
            self.assertEqual(names.count(f"camera screw hole {hole}"), 1)
        samples = json.loads((export.folder / "base.samples.json").read_text())
        gmsh.initialize()
        self.addCleanup(gmsh.finalize)
        gmsh.option.setNumber("General.Terminal", 0)
        solids = gmsh.model.occ.importShapes(str(export.folder / "base.step"))
        gmsh.model.occ.synchronize()
        self.assertEqual([dimension for dimension, _ in solids], [3])
        # gmsh uses OpenCascade's integration of fixed order, which is less accurate.
        volume, exact = gmsh.model.occ.getMass(*solids[0]), samples["figures"]["volume_mm3"]
        self.assertLess(abs(volume - exact), 1e-4 * exact)

    def test_surfaces_parallel_to_an_ellipsoid_are_in_step_files(self):
        export = self.export("uvdtact", "black-gel")
        answer = StepJob(export.folder, export.folder, "black-gel").run()
        self.assertEqual((answer["passed"], answer["reason"]), (True, ""))
        self.assertEqual(answer["faces"], {"plane": 1, "surfaceofrevolution": 2})

    def test_the_same_design_gives_the_same_step_bytes(self):
        export = self.export("rtac0", "diffuser")
        written = []
        for _ in range(2):
            self.assertTrue(StepJob(export.folder, export.folder, "diffuser").run()["passed"])
            written.append((export.folder / "diffuser.step").read_bytes())
        self.assertEqual(written[0], written[1])


if __name__ == "__main__":
    unittest.main()
