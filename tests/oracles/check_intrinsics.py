"""Compares `fabkit calibrate intrinsics` with OpenCV's `fisheye.calibrate` on the same corners.

    python check_intrinsics.py PATH_TO_FABKIT

numpy simulates fifteen views of a board through a Kannala-Brandt lens with 0.1 px of noise, ten times. OpenCV gets the
nominal lens as its first guess, without which it does not start. Focal lengths and centres must agree within 0.1 % of
the focal length, and fabkit's residuals must not be larger. Of fabkit only the command and its files are used.
"""

import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy

SIZE = (640, 480)
TRUTH = numpy.array([281.3, 280.6, 322.7, 236.2])
COEFFICIENTS = numpy.array([0.021, -0.011, 0.0035, -0.0006])
NOMINAL_PX_PER_RAD = math.hypot(*SIZE) / math.radians(160)
COLUMNS, ROWS, SQUARE_MM = 9, 6, 3.0
VIEWS, TRIALS, NOISE_PX = 15, 10, 0.1
# Largest angle to the axis: OpenCV's fisheye model is silently wrong beyond 90 degrees.
FARTHEST = math.radians(80)
AGREEMENT = 1e-3


def project(points: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Projects points (n, 3) in the camera frame to pixels (n, 2); also returns their angles to the axis."""
    radius = numpy.hypot(points[:, 0], points[:, 1])
    theta = numpy.arctan2(radius, points[:, 2])
    powers = theta[:, None] ** numpy.array([3, 5, 7, 9])
    distorted = theta + powers @ COEFFICIENTS
    scale = (distorted / numpy.maximum(radius, 1e-12))[:, None]
    return TRUTH[:2] * points[:, :2] * scale + TRUTH[2:], theta


def rotation(vector: numpy.ndarray) -> numpy.ndarray:
    return cv2.Rodrigues(vector)[0]


def views(random: numpy.random.Generator, board: numpy.ndarray) -> list[numpy.ndarray]:
    """Simulates noisy pixels of all corners, for views with the whole board in the image."""
    centred = board - board.mean(axis=0)
    found = []
    while len(found) < VIEWS:
        turn, way, tilt_way = random.uniform(0, 2 * math.pi, 3)
        aside, tilt = random.uniform(0, math.radians(60)), random.uniform(0, math.radians(50))
        tilted = rotation(tilt * numpy.array([math.cos(tilt_way), math.sin(tilt_way), 0.0]))
        sideways = rotation(aside * numpy.array([math.cos(way), math.sin(way), 0.0]))
        placed = centred @ (tilted @ rotation(numpy.array([0.0, 0.0, turn]))).T
        points = (placed + [0.0, 0.0, random.uniform(9.5, 35.0)]) @ sideways.T
        pixels, theta = project(points)
        inside = (pixels > 2).all() and (pixels < numpy.array(SIZE) - 3).all()
        if inside and theta.max() < FARTHEST:
            found.append(pixels + random.normal(scale=NOISE_PX, size=pixels.shape))
    return found


def by_opencv(board: numpy.ndarray, pixels: list[numpy.ndarray]) -> tuple[numpy.ndarray, float]:
    centre = [(SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2]
    matrix = numpy.array(
        [[NOMINAL_PX_PER_RAD, 0, centre[0]], [0, NOMINAL_PX_PER_RAD, centre[1]], [0, 0, 1.0]]
    )
    flags = (
        cv2.CALIB_USE_INTRINSIC_GUESS
        | cv2.CALIB_RECOMPUTE_EXTRINSIC
        | cv2.CALIB_FIX_SKEW
    )
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-10)
    rms, matrix, *_ = cv2.fisheye.calibrate(
        [board.reshape(1, -1, 3)] * len(pixels),
        [view.reshape(1, -1, 2) for view in pixels],
        SIZE,
        matrix,
        numpy.zeros((4, 1)),
        flags=flags,
        criteria=criteria,
    )
    return numpy.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]), rms


def by_fabkit(binary: str, pixels: list[numpy.ndarray]) -> dict:
    corners = [
        {"id": row * (COLUMNS - 1) + column, "in_board_mm": [SQUARE_MM * (column + 1), SQUARE_MM * (row + 1)]}
        for row in range(ROWS - 1)
        for column in range(COLUMNS - 1)
    ]
    document = {
        "format": "fabkit-board",
        "version": 1,
        "name": "test",
        "kind": "checkerboard",
        "squares": [COLUMNS, ROWS],
        "square_mm": SQUARE_MM,
        "corners": corners,
    }
    rows = [
        f"view {view:02},{corner},{x!r},{y!r}"
        for view, found in enumerate(pixels)
        for corner, (x, y) in enumerate(found.tolist())
    ]
    with tempfile.TemporaryDirectory() as folder:
        board, list_of_corners = Path(folder, "board.json"), Path(folder, "corners.csv")
        board.write_text(json.dumps(document))
        list_of_corners.write_text("view,corner,x_px,y_px\n" + "\n".join(rows) + "\n")
        command = [binary, "--json", "calibrate", "intrinsics", "rtac0", "--board", str(board)]
        command += ["--corners", str(list_of_corners), "--model", "kannala-brandt"]
        command += ["-o", str(Path(folder, "camera.yaml"))]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}: exit {done.returncode}\n{done.stdout}{done.stderr}")
        return json.loads(done.stdout)


def main() -> None:
    (binary,) = sys.argv[1:]
    grid = [[column, row, 0.0] for row in range(1, ROWS) for column in range(1, COLUMNS)]
    board = SQUARE_MM * numpy.array(grid)
    worst, errors = 0.0, {"fabkit": [], "opencv": []}
    for trial in range(TRIALS):
        pixels = views(numpy.random.default_rng(trial), board)
        theirs, their_rms = by_opencv(board, pixels)
        document = by_fabkit(binary, pixels)
        names = ["fx_px", "fy_px", "cx_px", "cy_px"]
        ours = numpy.array([document["parameters"][name] for name in names])
        apart = (numpy.abs(ours - theirs) / TRUTH[0]).max()
        worst = max(worst, apart)
        errors["fabkit"].append(ours - TRUTH)
        errors["opencv"].append(theirs - TRUTH)
        assert apart < AGREEMENT, f"trial {trial}: fabkit {ours}, OpenCV {theirs}"
        our_rms = document["reprojection_rms_px"]
        assert our_rms < 1.001 * their_rms, f"trial {trial}: rms {our_rms} and {their_rms} px"
    spread = {who: numpy.sqrt(numpy.mean(numpy.square(all))) for who, all in errors.items()}
    print(
        f"intrinsics: fabkit and OpenCV {cv2.__version__} agree within {worst:.1e} of the focal length "
        f"in {TRIALS} x {VIEWS} views; rms error of fx, fy, cx, cy: fabkit {spread['fabkit']:.3f} px, "
        f"OpenCV {spread['opencv']:.3f} px"
    )


if __name__ == "__main__":
    main()
