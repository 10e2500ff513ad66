"""Touches a ball with a sensor in MuJoCo: how deep each taxel is pressed, and the force of a bed of springs.

    pip install mujoco numpy
    fabkit export rtac0 --robot mjcf -o robot
    fabkit press rtac0 --indenter ball@0deg,0deg --depth 0.8mm --csv curve.csv
    python mujoco_touch.py robot curve.csv

MuJoCo's layers are rigid: what its `tactile` sensor reads are depths, by the nearest way out of the ball: less than along a taxel's
normal, which pybullet_touch.py has. Each taxel is given a spring as stiff as the layers below it in series; the last column is the
force of fabkit's elastic solution of the same ball, where layers also give way beside the contact and keep their volume: what a bed
of springs leaves out.
"""

import csv
import json
import sys
from pathlib import Path

import mujoco
import numpy as np

# Of the indenter `ball`, its radius.
BALL_MM = 2.5

folder = Path(sys.argv[1])
robot = json.loads((folder / "robot.json").read_text())
taxels = np.load(folder / "robot-taxels.npz")
soft = robot["soft"]
spring_n_per_mm = soft["in_series_mpa"] * taxels["area_mm2"] / soft["thickness_mm"]

frame = next(frame for frame in robot["frames"] if frame["name"] == "touch_frame")
middle, normal = 1000 * np.array(frame["place_m"]), np.array(frame["rotation"])[:, 2]
spec = mujoco.MjSpec.from_file(str(folder / f"{robot['sensor']}.mjcf.xml"))
ball = spec.worldbody.add_body(name="ball", pos=middle / 1000)
# What cannot move meets nothing else that cannot.
ball.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=normal)
ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[BALL_MM / 1000, 0, 0], mass=0.01)
model = spec.compile()
data = mujoco.MjData(model)

with open(sys.argv[2], newline="") as file:
    curve = [row for row in csv.DictReader(file) if float(row["depth_mm"]) > 0]
print("depth mm  felt mm  springs N  fabkit N")
for row in curve:
    depth_mm = float(row["depth_mm"])
    data.qpos[0] = (BALL_MM - depth_mm) / 1000
    mujoco.mj_forward(model, data)
    # One number for each vertex along its normal, then two along the surface; metres.
    felt_mm = 1000 * data.sensordata.reshape(3, -1)[0]
    force_n = (spring_n_per_mm * felt_mm).sum()
    print(f"{depth_mm:8.3f} {felt_mm.max():8.3f} {force_n:10.3f} {float(row['force_n']):9.3f}")
