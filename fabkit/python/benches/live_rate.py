"""Presses a second of sensors that are kept ready, on one core.

python live_rate.py [SENSOR...]
"""

import os
import sys
import time

os.environ["RAYON_NUM_THREADS"] = "1"

import numpy as np

import fabkit.sim

SIZE_PX = (160, 120)
SPACING_MM = {
    "rtac0": 0.5,
    "9dtact": 0.4,
    "tactip": 0.7,
    "uvdtact": 0.5,
    "digit-like": 0.4,
    "shadowtac": 0.5,
}
BALL_MM = 4.0
COUNT = 30


def rate(name):
    sensor = fabkit.sim.Sensor(name, size_px=SIZE_PX, spacing_mm=SPACING_MM[name])
    top = sensor.sensor_from_touch[:3, 3]
    random = np.random.default_rng(0)
    offs = [[*random.uniform(-2, 2, 2), BALL_MM - random.uniform(0.2, 0.8)] for _ in range(COUNT)]
    presses = [fabkit.sim.ball(BALL_MM).at(*(top + off)) for off in offs]
    sensor.press(presses[0])
    begun = time.perf_counter()
    for press in presses:
        sensor.press(press, seed=1)
    return COUNT / (time.perf_counter() - begun)


def skin_rate(lights):
    """Of the fluidic sensor, whose skin answers presses together: eight at a time."""
    skin = fabkit.sim.Skin("fluidic", size_px=SIZE_PX, spacing_mm=2.0)
    presses = [f"hemisphere@{20 - i}mm,{3 + i}mm,{1 + 0.1 * i:.1f}mm" for i in range(8)]
    begun = time.perf_counter()
    skin.press_all(presses, lights=lights)
    return len(presses) / (time.perf_counter() - begun)


for name in sys.argv[1:] or [*SPACING_MM, "fluidic"]:
    if name == "fluidic":
        for lights in [["white"], ["white", "display"]]:
            print(f"fluidic, pictures in {' and '.join(lights)}: {skin_rate(lights):.1f} a second")
    else:
        print(f"{name}: {rate(name):.1f} a second")
