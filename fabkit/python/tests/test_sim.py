"""Prepared sensors (`fabkit.sim`) agree with single presses and captures."""

import pickle
import runpy
from pathlib import Path

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.testing import assert_allclose, assert_array_equal

import fabkit
import fabkit.sim as sim

SIZE_PX = (80, 60)
PRESS = "hemisphere@30deg,0deg,0.8mm"
TIP_MM = 21.0


@pytest.fixture(scope="module")
def rtac0():
    return sim.Sensor("rtac0", size_px=SIZE_PX, spacing_mm=0.6)


def test_prepared_press_agrees_with_press_and_capture(rtac0):
    felt = rtac0.press(PRESS, seed=None)
    single = fabkit.press("rtac0", "hemisphere@30deg,0deg", 0.8, spacing_mm=0.6, steps=1)
    # One solves a patch around the contact, the other the whole dome: nodes differ.
    assert_allclose(felt.force_n, single.force_n, atol=0.05 * np.linalg.norm(single.force_n))
    captured = rtac0.scene.capture(PRESS, seed=None, spacing_mm=0.6)
    assert np.abs(felt.image - captured.grey.round()).max() <= 3
    seen = captured.truth.contact & felt.contact
    assert seen.sum() > 0.8 * captured.truth.contact.sum()
    assert_allclose(felt.depth_mm[seen], captured.truth.indentation_mm[seen], atol=1e-3)
    # Interpolation between nodes 0.6 mm apart.
    assert abs(felt.deepest_mm - 0.8) < 0.05


@pytest.mark.parametrize("name", ["rtac0", "digit-like"])
def test_resized_sensor_has_the_same_view(name):
    """Compare each pixel with the middle of the four it replaces, with and without refraction."""
    scene = fabkit.depth.Scene(name)
    camera = scene.camera
    small = scene.resized(camera.width_px // 2, camera.height_px // 2)
    full = scene.cast().point_in_sensor
    middle = (full[::2, ::2] + full[1::2, ::2] + full[::2, 1::2] + full[1::2, 1::2]) / 4
    off_mm = np.linalg.norm(small.cast().point_in_sensor - middle, axis=2)
    assert np.nanmedian(off_mm) < 0.005
    again = pickle.loads(pickle.dumps(small))
    assert_array_equal(again.cast().range_mm, small.cast().range_mm)


def test_presses_are_independent(rtac0):
    presses = [sim.Asked(f"hemisphere@20deg,{a}deg,0.5mm", seed=a) for a in (0, 120, 240)]
    many = rtac0.press_all(presses)
    for i, asked in enumerate(presses):
        one = rtac0.press(asked.presser, seed=asked.seed)
        for name in ("image", "depth_mm", "contact", "force_n", "mark_px"):
            assert_array_equal(getattr(many[i], name), getattr(one, name))
    assert len(many) == 3


@pytest.mark.parametrize(
    ("name", "light", "press", "spacing_mm"),
    [
        ("tactip", None, "disc-107@20deg,30deg,1mm", 0.8),
        ("uvdtact", "uv", "hemisphere@20deg,30deg,0.5mm", 0.6),
    ],
)
def test_prepared_sensor_renders_like_capture(name, light, press, spacing_mm):
    """Check images with markers and fluorescent layers, where only changed pixels are redrawn."""
    sensor = sim.Sensor(name, size_px=(80, 60), spacing_mm=spacing_mm, light=light)
    felt = sensor.press(press, seed=None)
    captured = sensor.scene.capture(press, seed=None, spacing_mm=spacing_mm, light=light)
    off = np.abs(felt.image - captured.grey.round())
    assert off.max() <= 6
    assert np.mean(off > 1) < 0.01
    changed = np.abs(captured.grey - sensor.press(seed=None).image)
    assert changed.max() > 20


def test_gymnasium_environment():
    """Check the example's environment by gymnasium's own rules."""
    path = Path(__file__).parents[1] / "examples/robots/gymnasium_touch.py"
    touch = runpy.run_path(str(path))["Touch"]()
    check_env(touch, skip_render_check=True)
    _, told = touch.reset(seed=1)
    _, reward, *_ = touch.step(np.array([0.1], dtype=np.float32))
    assert reward == -abs(touch.depth_mm - told["wanted_mm"])


def test_first_contact_does_not_fail(rtac0):
    """Check that a control loop does not fail between no contact and the first contact."""
    depths_mm = [0.002, 0.005, 0.01, 0.02]
    tip = rtac0.sensor_from_touch[:3, 3]
    felt = [rtac0.press(sim.ball(4.0).at(*np.add(tip, [0, 0, 4.0 - mm]))) for mm in depths_mm]
    forces = [-one.force_n[2] for one in felt]
    assert forces == sorted(forces)
    assert forces[-1] < 0.01


def test_press_without_contact_is_the_rest_state(rtac0):
    rest, apart = rtac0.press(seed=None), rtac0.press(sim.ball(2.0).at(0, 0, 40), seed=None)
    assert_array_equal(rest.image, apart.image)
    assert not apart.contact.any()
    assert not apart.force_n.any()
    assert rest.deepest_mm == 0.0


def test_custom_bodies(rtac0):
    """Compare a box by edges with one by triangles, and a ball with a named press."""
    at = (0.5, 0, TIP_MM + 3 - 0.4)
    mesh = fabkit.sim.convex(*_box_mesh(4, 5, 6))
    felt = [rtac0.press(body.at(*at), seed=None) for body in (sim.box(4, 5, 6), mesh)]
    assert_allclose(felt[0].force_n, felt[1].force_n, atol=1e-9)
    assert_allclose(felt[0].depth_mm, felt[1].depth_mm, atol=1e-6)
    assert felt[0].force_n[2] < -0.1
    # Two bodies at once give more force than one.
    both = rtac0.press([sim.ball(3).at(4, 0, 22.5), sim.ball(3).at(-4, 0, 22.5)], seed=None)
    one = rtac0.press(sim.ball(3).at(4, 0, 22.5), seed=None)
    assert both.force_n[2] < 1.5 * one.force_n[2] < 0
    # Nodes of neighbouring rings are rotated by a fraction of a step against each other.
    assert abs(both.force_n[0]) < 0.01 * abs(both.force_n[2])


def test_shear_needs_friction(rtac0):
    straight = rtac0.press(PRESS, seed=None)
    along = rtac0.press(PRESS, shear_mm=(0.0, "0.3 mm"), friction=0.5, seed=None)
    assert abs(along.force_n[1]) > 0.02 > abs(straight.force_n[1])


@pytest.mark.parametrize(
    ("presser", "says"),
    [
        ("hemisphere@30deg,0deg,9mm", "9 mm"),
        ("hammer@30deg,0deg,1mm", "hammer"),
        (sim.ball(-1.0), "radius"),
        (sim.Body("star", (1.0,), np.eye(4)), "star"),
        (sim.ball(1.0).placed(2 * np.eye(4) - np.diag([0, 0, 0, 1])), "rigid"),
    ],
)
def test_impossible_presses_are_errors(rtac0, presser, says):
    with pytest.raises(fabkit.FabkitError, match=says):
        rtac0.press(presser)
    # The sensor still works after the error.
    assert rtac0.press(PRESS).contact.any()


def test_concave_mesh_is_an_error():
    points, triangles = _box_mesh(2, 2, 2)
    dented = points.copy()
    dented[0] *= 0.1
    with pytest.raises(fabkit.FabkitError, match="not convex"):
        sim.convex(dented, triangles)
    with pytest.raises(fabkit.FabkitError, match="not convex"):
        sim.convex(points, triangles[:, ::-1])


def test_depth_is_reconstructed_from_captures(rtac0):
    felt, rest = rtac0.press("hemisphere@20deg,90deg,1mm", seed=4), rtac0.press(seed=9)
    depth_mm, contact = rtac0.reconstruct(felt.image, rest.image)
    assert contact.sum() > 0.8 * felt.contact.sum()
    assert abs(np.nanmax(depth_mm) - 1.0) < 0.3
    with pytest.raises(fabkit.FabkitError, match="px"):
        rtac0.reconstruct(felt.image[:-1], rest.image)
    # A 12-bit camera's values in 16 bits.
    narrow = [np.asarray(one, np.uint16) * 16 for one in (felt.image, rest.image)]
    with pytest.raises(fabkit.FabkitError, match="fewer bits than the file has room for"):
        rtac0.reconstruct(*narrow)


def test_markers_are_tracked_by_name():
    skin = sim.Skin("fluidic", spacing_mm=2.0)
    presses = ["hemisphere@20mm,3mm,0.1mm", "hemisphere@20mm,3mm,4mm"]
    many = skin.press_all(presses, lights=["white", "display"], seed=3)
    for light, true_px in (("white", many.mark_px), ("display", many.column_px)):
        rest, pressed = many.images[light]
        marks = sim.MarkFollower("fluidic", rest, light=light)
        both = marks.follow(many.images[light])
        assert both.px.shape == (2, len(marks.names), 2)
        assert both.moved_mm.shape == (2, len(marks.names), 3)
        assert both.seen.all()
        assert_array_equal(both.px[0], marks.rest_px)
        assert_array_equal(marks.follow(pressed).px, both.px[1])
        # With one ray for each pixel, a marker is located to 0.1 px, a column's end to a pixel.
        off = np.linalg.norm(both.moved_px[1] - (true_px[1] - true_px[0]), axis=1)
        assert np.median(off) < (0.15 if light == "white" else 0.5)
    assert marks.names == [f"column {i + 1}" for i in range(16)]
    with pytest.raises(fabkit.FabkitError, match="px"):
        marks.follow(pressed[:-1])
    with pytest.raises(fabkit.FabkitError, match="no value exceeds"):
        sim.MarkFollower("rtac0", np.zeros((480, 640), np.uint8))


def test_a_skin_with_channels():
    skin = sim.Skin("fluidic", spacing_mm=2.0)
    many = skin.press_all(["hemisphere@20mm,3mm,1mm", "hemisphere@20mm,3mm,2mm"])
    assert many.force_n[1, 2] < many.force_n[0, 2] < 0
    assert many.column_px.shape == (2, len(skin.column_names), 2)
    assert np.abs(many.column_mm[1]).max() > np.abs(many.column_mm[0]).max() > 0
    assert many.mark_displacement_mm.shape == (2, len(skin.mark_names), 3)
    assert many.images == {}
    with pytest.raises(fabkit.FabkitError, match="rtac0"):
        sim.Skin("rtac0")


def test_images_of_a_skin():
    skin = sim.Skin("fluidic", spacing_mm=2.0, size_px=(160, 120))
    presses = ["hemisphere@20mm,3mm,2mm", "hemisphere@-20mm,3mm,0.5mm"]
    lights = ["display", "white"]
    both = skin.press_all(presses, lights=lights, seed=7)
    assert both.images["display"].shape == (2, 120, 160, 3)
    assert both.images["white"].shape == (2, 120, 160)
    # The noise of an image does not depend on the other images of the call.
    second = skin.press_all(presses[1:], lights=lights, seed=8)
    for light in lights:
        assert_array_equal(second.images[light][0], both.images[light][1])
    # Markers are bright at `mark_px`, pressed and not.
    ideal = skin.press_all(presses, lights=["white"], seed=None)
    for image, pixels in zip(ideal.images["white"], ideal.mark_px, strict=True):
        columns, rows = pixels[np.isfinite(pixels).all(axis=1)].round().astype(int).T
        inside = (columns > 1) & (columns < 158) & (rows > 1) & (rows < 118)
        assert image[rows[inside], columns[inside]].min() > 2 * np.median(image)
    with pytest.raises(fabkit.FabkitError, match="white, display"):
        skin.press_all(presses, lights=["uv"])


def _box_mesh(x_mm, y_mm, z_mm):
    half = np.array([x_mm, y_mm, z_mm]) / 2
    points = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)]) * 2 * half - half
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return points, np.array(triangles)
