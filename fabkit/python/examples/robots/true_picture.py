"""Turns the picture of a simulator's pinhole into that of the sensor's own camera: fisheye and refraction by one table.

    pip install numpy opencv-python-headless
    fabkit export rtac0 --robot mjcf -o robot
    python true_picture.py robot pinhole.png true.png

`pinhole.png` is what the simulator's camera sees, in the size that `robot.json` states; any simulator's will do.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np

folder = Path(sys.argv[1])
pinhole = json.loads((folder / "robot.json").read_text())["camera"]["pinhole"]
picture = cv2.imread(sys.argv[2], cv2.IMREAD_UNCHANGED)
if picture.shape[:2] != (pinhole["height_px"], pinhole["width_px"]):
    sys.exit(f"{sys.argv[2]} is {picture.shape[1]} x {picture.shape[0]} px, but the pinhole has "
             f"{pinhole['width_px']} x {pinhole['height_px']}")
where = np.load(folder / "robot-rays.npz")["pinhole_px"]
# Black where the lens reaches farther than a pinhole does.
true = cv2.remap(picture, np.nan_to_num(where[..., 0], nan=-1), np.nan_to_num(where[..., 1], nan=-1), cv2.INTER_LINEAR)
cv2.imwrite(sys.argv[3], true)
