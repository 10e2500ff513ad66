"""Camera projections are vectorised, invertible and differentiable."""

import pickle

import numpy as np
import pytest

import fabkit


@pytest.fixture(scope="module")
def camera():
    plain = fabkit.Camera.equidistant(640, 480, np.deg2rad(160))
    return plain.with_parameters({"k1": 0.02, "k2": -0.004, "cx_px": 310.0})


@pytest.fixture(scope="module")
def points():
    return np.random.default_rng(1).normal(size=(7, 5, 3)) * [5, 5, 1] + [0, 0, 6]


def test_projection_is_kannala_and_brandts(camera, points):
    # J. Kannala and S. Brandt, PAMI 2006: r = theta + k1 theta^3 + k2 theta^5.
    p = camera.parameters
    across = np.hypot(points[..., 0], points[..., 1])
    theta = np.arctan2(across, points[..., 2])
    r = theta + p["k1"] * theta**3 + p["k2"] * theta**5
    columns = p["fx_px"] * r * points[..., 0] / across + p["cx_px"]
    rows = p["fy_px"] * r * points[..., 1] / across + p["cy_px"]
    pixels = camera.project(points)
    assert pixels.shape == (7, 5, 2)
    np.testing.assert_allclose(pixels, np.stack([columns, rows], -1), rtol=0, atol=1e-9)


def test_unproject_inverts_project(camera, points):
    origins, directions = camera.unproject(camera.project(points))
    np.testing.assert_array_equal(origins, np.zeros((7, 5, 3)))
    expected = points / np.linalg.norm(points, axis=-1, keepdims=True)
    np.testing.assert_allclose(directions, expected, rtol=0, atol=1e-12)


def test_derivatives_are_those_of_the_projection(camera, points):
    pixels, by_point, by_parameters = camera.project_with_jacobians(points)
    np.testing.assert_allclose(pixels, camera.project(points), rtol=0, atol=1e-11)
    # Central differences: the error is h^2 f''' / 6, with rounding 1e-13 / h.
    h = 1e-4
    for axis, step in enumerate(np.eye(3) * h):
        numeric = (camera.project(points + step) - camera.project(points - step)) / (2 * h)
        np.testing.assert_allclose(by_point[..., axis], numeric, rtol=0, atol=1e-5)
    for place, (name, value) in enumerate(camera.parameters.items()):
        there, here = (camera.with_parameters({name: value + s * h}) for s in (1, -1))
        numeric = (there.project(points) - here.project(points)) / (2 * h)
        np.testing.assert_allclose(by_parameters[..., place], numeric, rtol=0, atol=1e-5)


def test_unseen_points_project_to_nan(camera):
    pixels = camera.project([[0, 0, 1], [0, 0, -1], [np.nan, 0, 1]])
    assert np.isfinite(pixels[0]).all()
    assert np.isnan(pixels[1:]).all()
    assert camera.project(np.zeros((0, 3))).shape == (0, 2)


def test_memory_layout_and_batching_do_not_matter(camera, points):
    expected = camera.project(points)
    np.testing.assert_array_equal(camera.project(np.asfortranarray(points)), expected)
    np.testing.assert_array_equal(camera.project(points[::2]), expected[::2])
    np.testing.assert_array_equal(camera.project([3, 4, 5]), camera.project([3.0, 4.0, 5.0]))


def test_files_and_pickles_keep_everything(camera, tmp_path):
    camera.save(tmp_path / "camera.yaml")
    assert fabkit.Camera.load(tmp_path / "camera.yaml") == camera
    assert pickle.loads(pickle.dumps(camera)) == camera
    for format in ("opencv", "ros", "kalibr"):
        again = fabkit.Camera.from_text(camera.to_text(format))
        assert again.parameters == pytest.approx(camera.parameters, rel=1e-12)
    (tmp_path / "bad.yaml").write_text("fabkit_camera: 1\nwidth_px: -3\n")
    with pytest.raises(fabkit.FabkitError, match=r"bad\.yaml") as caught:
        fabkit.Camera.load(tmp_path / "bad.yaml")
    assert caught.value.code == "bad-input"


def test_one_camera_of_several_is_named_and_unusual_ones_warn(tmp_path):
    # COLMAP's pixel centres are half a pixel off.
    text = "1 PINHOLE 640 480 500 500 320 240\n2 PINHOLE 640 480 500 500 170 240\n"
    (tmp_path / "cameras.txt").write_text(text)
    camera = fabkit.Camera.load(f"{tmp_path / 'cameras.txt'}#1")
    assert camera.parameters["cx_px"] == 319.5
    with pytest.warns(UserWarning, match="far from the centre"):
        assert fabkit.Camera.from_text(text, "2").parameters["cx_px"] == 169.5
    with pytest.warns(UserWarning, match="far from the centre"):
        fabkit.depth.Scene("rtac0", camera=f"{tmp_path / 'cameras.txt'}#2")
    with pytest.raises(fabkit.FabkitError, match="holds 2 cameras: `1`, `2`"):
        fabkit.Camera.load(tmp_path / "cameras.txt")
    with pytest.raises(fabkit.FabkitError, match="in metres"):
        fabkit.Camera.from_text("1 PINHOLE 640 480 0.0036 0.0036 0.00192 0.00144\n")


def test_a_scenes_camera_and_pose_make_the_same_scene() -> None:
    scene = fabkit.depth.Scene("rtac0").resized(64, 48)
    camera_from_sensor = np.linalg.inv(scene.sensor_from_camera)
    again = fabkit.depth.Scene("rtac0", camera=scene.camera, pose=camera_from_sensor)
    # Two matrix inverses cause the difference; without the glass, points would be off by 0.05 mm.
    np.testing.assert_allclose(
        again.cast().point_in_sensor, scene.cast().point_in_sensor, rtol=0, atol=1e-9
    )
