"""Calibration from arrays recovers the camera and pose that made the data."""

import json
import pickle
import subprocess
import sys

import numpy as np
import pytest

import fabkit
from fabkit.calibrate import Corners, Pins


@pytest.fixture(scope="module")
def board():
    return fabkit.calibrate.boards("rtac0")["checkerboard"]


@pytest.fixture(scope="module")
def truth(rtac0):
    return rtac0.camera.with_parameters({"fx_px": 300.0, "fy_px": 301.0, "cx_px": 325.0})


def rotation(vector):
    """Compute a rotation matrix from a rotation vector by Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def views(board, camera, sigma_px, count=12):
    random = np.random.default_rng(7)
    corners = np.column_stack([board.corners_mm, np.zeros(len(board.corners_mm))])
    corners -= corners.mean(0)
    for _ in range(count):
        turned = corners @ rotation(random.normal(size=3) * 0.4).T
        pixels = camera.project(turned + random.normal(size=3) * [15, 15, 8] + [0, 0, 90])
        inside = ((pixels > 0) & (pixels < [639, 479])).all(1)
        noise = random.normal(size=pixels.shape) * sigma_px
        yield Corners(np.flatnonzero(inside), (pixels + noise)[inside], sigma_px)


def test_intrinsics_from_corners(rtac0, board, truth):
    found = fabkit.calibrate.intrinsics(
        rtac0, board, list(views(board, truth, 0.1)), models=["kannala-brandt"]
    )
    # The length of two residuals of 0.1 px; hundreds of corners determine it to a few percent.
    assert found.rms_px == pytest.approx(0.1 * np.sqrt(2), rel=0.05)
    sigmas = found.camera.sigmas
    for name in ("fx_px", "fy_px", "cx_px", "cy_px"):
        error = abs(found.camera.parameters[name] - truth.parameters[name])
        assert error < 4 * sigmas[name], name
    assert found.camera.covariance.shape == (8, 8)
    assert found.document["format"] == "fabkit-intrinsics"


def render(board, square_px=22):
    """Draw a board seen perpendicularly; each pixel is the mean of its area."""
    columns, rows = board.document["squares"]
    over = 4
    squares = np.indices((rows, columns)).sum(0) % 2
    small = np.kron(squares, np.ones((square_px * over, square_px * over)))
    # Shifted by fractions of a pixel, on white.
    page = np.ones((480 * over, 640 * over))
    page[37 : 37 + small.shape[0], 41 : 41 + small.shape[1]] = 0.1 + 0.8 * small
    picture = page.reshape(480, over, 640, over).mean((1, 3))
    corners = board.corners_mm / board.document["square_mm"] * square_px
    return picture, corners + np.array([41, 37]) / over - 0.5


@pytest.mark.parametrize("detector", ["fabkit", "opencv"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float64])
def test_corners_are_found(board, detector, dtype):
    if detector == "opencv":
        pytest.importorskip("cv2")
    picture, expected = render(board)
    if dtype != np.float64:
        picture = np.rint(picture * np.iinfo(dtype).max).astype(dtype)
    found = fabkit.calibrate.find_corners(picture, board, detector=detector)
    assert len(found.ids) == len(expected)
    # The board looks the same after half a turn.
    errors = [np.abs(found.pixels - e[found.ids]).max() for e in (expected, expected[::-1])]
    # OpenCV's corners are off by 0.12 px here, all in the same direction.
    assert min(errors) < (0.1 if detector == "fabkit" else 0.2)


def test_unusable_images_are_errors(rtac0, board):
    grey = np.full((480, 640), 0.5)
    with pytest.raises(fabkit.FabkitError, match="no contrast"):
        fabkit.calibrate.find_corners(grey, board, detector="fabkit")
    random = np.random.default_rng(3)
    pictures = [random.random((480, 640)) for _ in range(3)]
    with pytest.raises(fabkit.FabkitError, match="view 1") as caught:
        fabkit.calibrate.intrinsics(rtac0, board, pictures, detector="fabkit")
    assert "10 to 20 images" in caught.value.hint
    with pytest.raises(fabkit.FabkitError, match="640 x 480"):
        fabkit.calibrate.intrinsics(rtac0, board, [grey[:100]], detector="fabkit")
    for wrong in (grey.astype(int), grey[0], np.zeros((4, 4, 2))):
        with pytest.raises(fabkit.FabkitError, match=r"dtype|shape"):
            fabkit.calibrate.find_corners(wrong, board)


def captures(pins, camera, pose, sigma_px):
    """Simulate captures with five pins of a dome each."""
    contacts = pins["contact_in_sensor_mm"] @ pose[:3, :3].T + pose[:3, 3]
    pixels = camera.project(contacts)
    seen = np.flatnonzero(
        np.isfinite(pixels).all(1) & ((pixels > 0) & (pixels < [640, 480])).all(1)
    )
    random = np.random.default_rng(5)
    for _ in range(12):
        few = random.choice(seen, 5, replace=False)
        noise = random.normal(size=(5, 2)) * sigma_px
        yield Pins(pixels[few] + noise, pins["hole"][few].tolist(), sigma_px)


def mounted(sensor):
    """Return a pose that differs slightly from the design's."""
    moved = np.eye(4)
    moved[:3, :3] = rotation(np.array([0.01, -0.02, 0.015]))
    moved[:3, 3] = [0.2, -0.15, 0.1]
    return np.linalg.inv(sensor.sensor_from_camera) @ moved


def test_extrinsics_from_pins(rtac0, tmp_path):
    dome = rtac0.fixtures["pin-dome"]
    pins = dome.landmarks[dome.landmarks["kind"] == "long"]
    pose = mounted(rtac0)
    seen = list(captures(pins, rtac0.camera, pose, 0.05))
    found = fabkit.calibrate.extrinsics(rtac0, rtac0.camera, seen, pin="long")
    error = np.linalg.inv(found.camera_from_sensor) @ pose
    sigma = np.sqrt(np.diagonal(found.covariance))
    assert np.abs(error[:3, 3]).max() < 5 * sigma[3:].max() + 1e-3
    assert np.abs(error[:3, :3] - np.eye(3)).max() < 5 * sigma[:3].max() + 1e-4
    # Ground truth reads the written file.
    found.save(tmp_path / "pose.yaml")
    by_file = fabkit.depth.Scene(rtac0, pose=tmp_path / "pose.yaml")
    by_result = fabkit.depth.Scene(rtac0, pose=found)
    np.testing.assert_allclose(by_file.sensor_from_camera, by_result.sensor_from_camera, atol=1e-12)
    assert by_file.camera == by_result.camera
    with pytest.raises(fabkit.FabkitError, match="no hole 99"):
        fabkit.calibrate.extrinsics(
            rtac0, rtac0.camera, [Pins(seen[0].pixels[:2], [1, 99])], pin="long"
        )


def test_joint_covariance_of_lens_and_pose(rtac0, board, truth, tmp_path):
    lens = fabkit.calibrate.intrinsics(
        rtac0, board, list(views(board, truth, 0.1)), models=["kannala-brandt"]
    )
    focal, sigma = lens.focal_px_per_rad
    assert abs(focal - truth.parameters["fx_px"]) < 4 * sigma
    assert 0 < lens.rays["seen"]["typical_px"] <= lens.rays["seen"]["worst_px"] < 0.5
    dome = rtac0.fixtures["pin-dome"]
    pins = dome.landmarks[dome.landmarks["kind"] == "long"]
    seen = list(captures(pins, truth, mounted(rtac0), 0.05))
    found = fabkit.calibrate.extrinsics(rtac0, lens.camera, seen, pin="long")
    names = found.joint_parameters
    assert names[5:7] == ["translation_z_mm", "fx_px"]
    assert names[6:] == list(found.camera.parameters)
    joint = found.joint_covariance
    np.testing.assert_allclose(joint[:6, :6], found.covariance)
    np.testing.assert_allclose(joint[6:, 6:], found.camera.covariance)
    # Pins alone cannot separate distance and focal length.
    assert abs(joint[5, 6]) > 0.1 * np.sqrt(joint[5, 5] * joint[6, 6])
    # The same sigma from the result, from its files, and in another process.
    found.save(tmp_path / "pose.yaml")
    scenes = [
        fabkit.depth.Scene(rtac0, pose=found),
        fabkit.depth.Scene(rtac0, pose=tmp_path / "pose.yaml"),
        pickle.loads(pickle.dumps(fabkit.depth.Scene(rtac0, pose=found))),
    ]
    sigmas = [scene.cast(print_sigma_mm=0.0).sigma_mm for scene in scenes]
    for scene, sigma_mm in zip(scenes, sigmas, strict=True):
        # Parameters that the chosen explanation fitted belong to the lens or the interface.
        assert scene.sigma_of in ("pose, lens, shape", "pose, lens, interface, shape")
        assert scene.sigma_parameters[:6] == names[:6]
        np.testing.assert_array_equal(sigma_mm, sigmas[0])
    apart = fabkit.depth.Scene(rtac0, pose=found, pose_covariance=found.covariance)
    assert apart.sigma_of.endswith("pose and camera as if independent")
    assert not np.allclose(apart.cast(print_sigma_mm=0.0).sigma_mm, sigmas[0], equal_nan=True)


def test_plan_equals_the_commands(tmp_path):
    # For this sensor no images of pins are rendered, which takes most of the time for others.
    planned = fabkit.calibrate.plan("tactip", captures=2, pins=5)
    words = ["calibrate", "plan", "tactip", "--captures", "2", "--pins", "5", "--json"]
    said = subprocess.run([sys.executable, "-m", "fabkit", *words], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    assert planned.document == json.loads(said.stdout)
    assert planned.done is None
    assert [len(capture.holes) for capture in planned.next] == [5, 5]
    last = planned.next[1]
    done = [last.holes] * 4
    after = fabkit.calibrate.plan("tactip", done=done, pin=last.kind, captures=1, pins=5)
    # Another capture improves the accuracy.
    assert after.next[0].expected.surface_mm < after.done.surface_mm
    # The same pins, listed in a folder; it has no images, as none are read.
    rows = [f"{i}.png,{hole},{last.kind}\n" for i in range(4) for hole in last.holes]
    (tmp_path / "captures.csv").write_text("file,hole,kind\n" + "".join(rows))
    assert fabkit.calibrate.plan("tactip", done=tmp_path, captures=1, pins=5) == after


def test_invalid_plan_arguments_are_errors():
    with pytest.raises(fabkit.FabkitError, match="hole 999"):
        fabkit.calibrate.plan("shadowtac", done=[[999]], pin="short")
    with pytest.raises(fabkit.FabkitError, match="limits are 1 and 500"):
        fabkit.calibrate.plan("shadowtac", captures=0)
    with pytest.raises(fabkit.FabkitError, match="say `pin`"):
        fabkit.calibrate.plan("shadowtac", done=[[1]])
    with pytest.raises(fabkit.FabkitError, match="kinds: long, short"):
        fabkit.calibrate.plan("shadowtac", done=[[1]], pin="long-ish")
    with pytest.raises(fabkit.FabkitError, match="fluidic"):
        fabkit.calibrate.plan("fluidic")
