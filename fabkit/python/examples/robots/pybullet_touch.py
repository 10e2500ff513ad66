"""Touches a ball with a sensor in PyBullet: how deep its convex pieces and each taxel are pressed, and the force of a bed of springs.

    pip install pybullet numpy
    fabkit export rtac0 --robot urdf -o robot
    fabkit press rtac0 --indenter ball@0deg,0deg --depth 0.8mm --csv curve.csv
    python pybullet_touch.py robot curve.csv

Bullet thickens convex pieces by a margin of a millimetre, so that its own contacts begin before anything touches and are so much too
deep. How deep each taxel lies in the ball is therefore asked with rays along its normal, which meet the ball alone. Springs and the
last column are as in mujoco_touch.py, where MuJoCo measures by the nearest way out of the ball: its springs give less.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pybullet

# Of the indenter `ball`, its radius.
BALL_M = 0.0025
# Rays meet what is in this group.
BALL_GROUP = 2
# Nearer than this is looked for, m.
NEAR_M = 1e-3

folder = Path(sys.argv[1])
robot = json.loads((folder / "robot.json").read_text())
taxels = np.load(folder / "robot-taxels.npz")
soft = robot["soft"]
spring_n_per_mm = soft["in_series_mpa"] * taxels["area_mm2"] / soft["thickness_mm"]

pybullet.connect(pybullet.DIRECT)
# Without the flag, Bullet makes up inertias from boxes around collision shapes.
sensor = pybullet.loadURDF(
    str(folder / f"{robot['sensor']}.urdf"), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE
)
ball = pybullet.createMultiBody(0.01, pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=BALL_M))
pybullet.setCollisionFilterGroupMask(ball, -1, BALL_GROUP, 1)

frame = next(frame for frame in robot["frames"] if frame["name"] == "touch_frame")
middle, normal = np.array(frame["place_m"]), np.array(frame["rotation"])[:, 2]
places, normals = taxels["place_mm"] / 1000, taxels["normal"]


def felt_m():
    """How deep each taxel lies in the ball: along its normal, from inside the layers."""
    inside = places - BALL_M * normals
    asked = pybullet.MAX_RAY_INTERSECTION_BATCH_SIZE - 1
    hits = []
    for i in range(0, len(places), asked):
        hits += pybullet.rayTestBatch(
            inside[i : i + asked].tolist(), places[i : i + asked].tolist(), collisionFilterMask=BALL_GROUP
        )
    # How far along the ray; 1 where it meets nothing.
    return np.array([(1 - hit[2]) * BALL_M for hit in hits])


with open(sys.argv[2], newline="") as file:
    curve = [row for row in csv.DictReader(file) if float(row["depth_mm"]) > 0]
print("depth mm  bullet mm  felt mm  springs N  fabkit N")
for row in curve:
    depth_mm = float(row["depth_mm"])
    pybullet.resetBasePositionAndOrientation(ball, middle + (BALL_M - depth_mm / 1000) * normal, [0, 0, 0, 1])
    met = pybullet.getClosestPoints(ball, sensor, NEAR_M)
    deepest_mm = -1000 * min((point[8] for point in met), default=0.0)
    felt_mm = 1000 * felt_m()
    force_n = (spring_n_per_mm * felt_mm).sum()
    print(f"{depth_mm:8.3f} {deepest_mm:10.3f} {felt_mm.max():8.3f} {force_n:10.3f} {float(row['force_n']):9.3f}")
