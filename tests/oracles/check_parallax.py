"""Measures the parallax error of a pinhole image that `pinhole_px` maps to the sensor's image, where it is pressed.

    python tests/oracles/check_parallax.py target/release/fabkit SENSOR PRESS...

The table holds for the surface at rest, so indented points are off. PRESS is as for `fabkit depth --press`, such as
`hemisphere@30deg,0deg,1mm`. Errors are in pixels of the sensor's image. On demand.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np


def main(fabkit, sensor, presses):
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        run([fabkit, "export", sensor, "--robot", "mjcf", "-o", folder / "robot", "-q"])
        camera = json.loads((folder / "robot/robot.json").read_text())
        pinhole = camera["camera"]["pinhole"]
        frame = next(one for one in camera["frames"] if one["name"] == camera["camera"]["frame"])
        table = np.load(folder / "robot/robot-rays.npz")["pinhole_px"].astype(float)
        # Number of pinhole pixels between neighbouring pixels of the sensor.
        step = np.hypot(*np.moveaxis(np.diff(table, axis=1, append=np.nan), -1, 0))
        all_px = []
        for i, press in enumerate(presses):
            file = folder / f"{i}.npz"
            run([fabkit, "depth", sensor, "--press", press, "-o", file, "-q"])
            truth = np.load(file)
            touched = truth["contact"] > 0
            local = (truth["point_in_sensor"][touched] / 1000 - frame["place_m"]) @ np.array(frame["rotation"])
            seen = pinhole["focal_px"] * local[:, :2] / local[:, 2:] + pinhole["middle_px"]
            off_px = np.hypot(*(seen - table[touched]).T) / step[touched]
            all_px.append(off_px[np.isfinite(off_px)])
        off_px = np.concatenate(all_px)
    told = ", ".join(f"{name} {np.quantile(off_px, q):.2f}" for name, q in [("median", 0.5), ("95 %", 0.95)])
    print(f"{sensor}: {len(off_px)} pixels in contact, {told} px")


def run(words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
