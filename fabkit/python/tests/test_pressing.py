"""Presses of soft layers from Python."""

import numpy as np
import pytest

import fabkit


def test_press_equals_the_commands(command, rtac0, tmp_path):
    options = {"shear_mm": ("0.1 mm", 0.05), "steps": 2, "spacing_mm": 0.6}
    pressed = fabkit.press(rtac0, "ball@30deg,120deg", "0.6 mm", **options)
    flags = ["--indenter=ball@30deg,120deg", "--depth=0.6mm", "--shear=0.1mm,0.05mm", "--steps=2"]
    theirs = command(
        "press", "rtac0", *flags, "--spacing=0.6mm", "--json", "-o", tmp_path / "a.npz"
    )
    theirs.pop("files")
    assert pressed.document == theirs
    assert list(pressed.force_n) == theirs["force_n"]
    with np.load(tmp_path / "a.npz") as field:
        for name in field.files:
            assert getattr(pressed, name).tobytes() == field[name].tobytes(), name


def test_nodes_add_up_to_the_force(rtac0):
    pressed = fabkit.press(rtac0, "ball@0deg,0deg", 0.5, steps=1, spacing_mm=0.6)
    by_nodes = -(pressed.pressure_mpa * pressed.area_mm2) @ pressed.outward
    # Each node stands for an area over which the normal varies slightly.
    assert by_nodes == pytest.approx(pressed.force_n, abs=0.02 * np.linalg.norm(pressed.force_n))
    assert pressed.contact_level == "linear"
    assert pressed.bulge_mm > 0.0


def test_linear_truth_lists_its_assumptions(rtac0):
    cast = fabkit.depth.cast
    truth = cast(rtac0, "ball@30deg,120deg,0.8mm", contact="linear", spacing_mm=0.6)
    assert truth.elastic is not None
    assert truth.elastic["is_simulated"]
    assert all(layer["source"] for layer in truth.elastic["layers"])
    assert np.nanmin(truth.indentation_mm) < -0.02
    assert cast(rtac0, "ball@30deg,120deg,0.8mm").elastic is None
