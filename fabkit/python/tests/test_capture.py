"""Simulated captures from Python."""

import pickle

import cv2
import numpy as np
import pytest

import fabkit
import fabkit.sim


def test_capture_equals_the_commands(command, tmp_path):
    press = "ball@1mm,-2mm,1mm"
    scene = fabkit.depth.Scene("9dtact")
    captured = scene.capture(press, seed=3, spacing_mm=0.5)
    truth = tmp_path / "truth.npz"
    theirs = command(
        *("capture", "9dtact", "--press", press, "--seed=3", "--spacing=0.5mm", "--json"),
        *("-o", tmp_path / "a.png", "--truth", truth),
    )
    assert {name: theirs[name] for name in captured.document} == captured.document
    with np.load(truth) as arrays:
        assert np.array_equal(
            arrays["indentation_mm"], captured.truth.indentation_mm, equal_nan=True
        )
    assert captured.grey.shape == (480, 640)
    assert captured.grey.max() <= 255
    # Darker in the contact than at rest, and brighter beside it.
    ideal = [scene.capture(p, seed=None, spacing_mm=0.5).grey for p in ((), press)]
    darker = ideal[0] - ideal[1]
    inside = captured.truth.contact
    assert darker[inside].max() > 5
    assert darker[~inside].min() < -0.1


def test_colour_captures_have_markers():
    captured = fabkit.depth.Scene("digit-like").capture(seed=None)
    assert captured.grey.shape == (480, 640, 3)
    # Each colour's light source is on its own side.
    columns = captured.grey[240].argmax(axis=0)
    assert columns[2] < 320 < columns[0]
    dots = fabkit.depth.Scene("tactip").capture(samples=4, seed=None)
    seen = [mark["pixel"] for mark in dots.document["marks"] if mark["pixel"]]
    assert dots.grey.shape == (30, 30)
    assert len(seen) > 40


def test_unknown_light_is_an_error():
    with pytest.raises(fabkit.FabkitError, match="no light `uv`: it has white"):
        fabkit.depth.Scene("rtac0").capture(light="uv")


def test_units_equal_the_commands(command, tmp_path):
    press = "ball@1mm,-2mm,1mm"
    scene = fabkit.depth.Scene("9dtact", unit=5)
    captured = scene.capture(press, seed=3, spacing_mm=0.5)
    theirs = command(
        *("capture", "9dtact", "--press", press, "--seed=3", "--spacing=0.5mm", "--json"),
        *("--unit=5", "-o", tmp_path / "a.png"),
    )
    assert theirs["unit"] == captured.document["unit"]
    assert theirs["unit"]["number"] == 5
    written = cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(written, np.rint(captured.grey).clip(0, 255))
    at_rest = scene.capture(seed=3).grey
    assert np.array_equal(pickle.loads(pickle.dumps(scene)).capture(seed=3).grey, at_rest)
    assert not np.array_equal(fabkit.depth.Scene("9dtact", unit=6).capture(seed=3).grey, at_rest)
    kept = fabkit.sim.Sensor("9dtact", unit=5, spacing_mm=0.5).press(seed=3).image
    assert np.array_equal(kept, np.rint(at_rest).clip(0, 255))
    with pytest.raises(fabkit.FabkitError, match="unit is -1"):
        fabkit.depth.Scene("9dtact", unit=-1)
