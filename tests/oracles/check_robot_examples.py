"""Runs the example scripts for simulators that install without a GPU, and checks their output.

    python tests/oracles/check_robot_examples.py target/release/fabkit
"""

import json
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

EXAMPLES = Path(__file__).parents[2] / "fabkit/python/examples/robots"
SENSOR = "rtac0"
# Largest ratio, either way, of forces by springs or by Drake's pressures to those of an elastic solution.
FORCES_WITHIN = 3.0
# Tolerance, and width, of a dot that is drawn in the pinhole's image and found in the sensor's image.
DOT_WITHIN_PX = 0.5
DOT_SIGMA_PX = 6.0


def main(fabkit):
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        robot, curve = folder / "robot", folder / "curve.csv"
        run([fabkit, "export", SENSOR, "--robot", "mjcf,urdf,drake,usd", "-o", robot, "-q"])
        run([fabkit, "press", SENSOR, "--indenter", "ball@0deg,0deg", "--depth", "0.8mm", "--csv", curve, "-q"])
        forces(example("mujoco_touch.py", robot, curve), felt=1)
        forces(example("pybullet_touch.py", robot, curve), felt=2)
        forces(example("drake_touch.py", robot, curve), felt=None)
        document = json.loads((robot / "robot.json").read_text())
        said = example("usd_stage.py", robot, folder / "stage.usda").split()
        # The sensor's links and the ball, of ten grams.
        assert int(said[0]) == len(document["links"]) + 1, said
        np.testing.assert_allclose(float(said[2]), 1000 * document["mass_kg"] + 10, atol=0.01)
        dots(folder, robot, document)
        read = runpy.run_path(str(EXAMPLES / "isaac_lab.py"))["read"]
        assert {"prim_path", "camera_cfg"} <= set(read(robot, "tacsl"))
        assert {"prim_path", "gelpad_dimensions"} <= set(read(robot, "tacex"))
    print("examples for MuJoCo, PyBullet, Drake, OpenUSD and OpenCV run")


def run(words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def example(name, *words):
    said = run([sys.executable, EXAMPLES / name, *words])
    print(f"{name}\n{said}", end="", flush=True)
    return said


def forces(said, felt):
    # PyBullet prints its build date before the table.
    table = said[said.index("depth mm") :]
    rows = np.array([line.split() for line in table.splitlines()[1:]], dtype=float)
    if felt is not None:
        np.testing.assert_allclose(rows[:, felt], rows[:, 0], rtol=0.02)
    theirs, ours = rows[:, -2], rows[:, -1]
    assert (np.diff(theirs) > 0).all()
    # The first contacts are smaller than a taxel and a tetrahedron: leave them out.
    ratio = (theirs / ours)[rows[:, 0] > 0.2]
    assert (1 / FORCES_WITHIN < ratio).all() and (ratio < FORCES_WITHIN).all(), ratio


def dots(folder, robot, document):
    """Draws dots in the pinhole's image at some taxels and checks their positions in the converted image."""
    taxels = np.load(robot / "robot-taxels.npz")
    pinhole = document["camera"]["pinhole"]
    frame = next(f for f in document["frames"] if f["name"] == document["camera"]["frame"])
    local = (taxels["place_mm"] / 1000 - frame["place_m"]) @ np.array(frame["rotation"])
    seen = pinhole["focal_px"] * local[:, :2] / local[:, 2:] + pinhole["middle_px"]
    size = np.array([pinhole["width_px"], pinhole["height_px"]])
    inner = (local[:, 2] > 0) & (np.abs(seen - size / 2) < size / 5).all(axis=1)
    chosen = np.flatnonzero(inner & (taxels["seen"] > 0) & (taxels["area_mm2"] > 0))[::10]
    rows, columns = np.mgrid[: size[1], : size[0]]
    for taxel in chosen[:8]:
        column, row = seen[taxel]
        spot = 255 * np.exp(-((rows - row) ** 2 + (columns - column) ** 2) / 2 / DOT_SIGMA_PX**2)
        cv2.imwrite(str(folder / "pinhole.png"), spot.round().astype(np.uint8))
        run([sys.executable, EXAMPLES / "true_picture.py", robot, folder / "pinhole.png", folder / "true.png"])
        true = cv2.imread(str(folder / "true.png"), cv2.IMREAD_GRAYSCALE).astype(float)
        y, x = np.mgrid[: true.shape[0], : true.shape[1]]
        found = np.array([(true * x).sum(), (true * y).sum()]) / true.sum()
        off = np.abs(found - taxels["pixel"][taxel]).max()
        assert off < DOT_WITHIN_PX, (taxel, off)


if __name__ == "__main__":
    main(sys.argv[1])
