"""Compares the constant for indirect light in captures with path-traced indirect light of Mitsuba 3.

    python check_mitsuba_bounce.py PATH_TO_FABKIT

Captures add the same indirect light everywhere, as a fraction of the mean direct light. Here Mitsuba 3 renders rooms
with a light source of 4 x 3 mm in the middle of the floor, and the script prints their indirect light beside the
constants of sensors with walls of the same reflectance. It tests no limit: the constant is an approximation. On
demand: `pip install mitsuba numpy`.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

# Half the side of the measured square, mm, and cells along it.
HALF, SIDE = 8.0, 20
SENSORS = ("rtac0", "fluidic", "uvdtact", "tactip", "9dtact", "shadowtac")


def constants(fabkit: str) -> dict[str, tuple[float, str]]:
    """Reads the constant and its source for each sensor that has one."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for sensor in SENSORS:
            command = [
                fabkit,
                "capture",
                sensor,
                "--reference",
                "--json",
                "-o",
                str(Path(folder) / f"{sensor}.png"),
            ]
            document = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
            bounce = [c for c in document["constants"] if c["name"] == "bounce"]
            # Sensors lit by glass fibres or channels have none.
            if bounce:
                found[sensor] = (bounce[0]["value"], bounce[0]["source"])
    return found


def diffuse(part: float) -> dict:
    return {
        "type": "twosided",
        "b": {"type": "diffuse", "reflectance": {"type": "rgb", "value": part}},
    }


def box(walls: float, top: float) -> dict:
    """Creates a room of 20 x 20 mm, 10 mm high."""
    faces = {}
    for name, axis, angle in (
        ("e", [0, 1, 0], 90),
        ("w", [0, 1, 0], -90),
        ("n", [1, 0, 0], 90),
        ("s", [1, 0, 0], -90),
    ):
        turned = (
            T().translate([0, 0, 5]).rotate(axis, angle).translate([0, 0, 10]).scale([10, 10, 1])
        )
        faces[name] = {"type": "rectangle", "to_world": turned, "bsdf": diffuse(walls)}
    faces["floor"] = {
        "type": "rectangle",
        "to_world": T().scale([10, 10, 1]),
        "bsdf": diffuse(walls),
    }
    top_face = T().translate([0, 0, 10]).scale([10, 10, 1])
    faces["top"] = {"type": "rectangle", "to_world": top_face, "bsdf": diffuse(top)}
    return faces


def dome(walls: float, top: float) -> dict:
    """Creates a hemisphere of radius 14 mm above a floor."""
    return {
        "floor": {"type": "disk", "to_world": T().scale(14), "bsdf": diffuse(walls)},
        "top": {"type": "sphere", "radius": 14.0, "bsdf": diffuse(top)},
    }


def ball(walls: float, top: float) -> dict:
    """Creates a sphere of radius 14 mm with the light source in its wall: direct light is uniform, as the constant
    assumes."""
    return {"top": {"type": "sphere", "center": [0, 0, 14], "radius": 14.0, "bsdf": diffuse(top)}}


def bounced(room: dict, top: float) -> tuple[float, float]:
    """Computes indirect light as a fraction of direct light, and its unevenness: standard deviation over mean."""
    # High enough in the sphere that the whole measured square is inside it.
    high = 1 if "floor" in room else 9
    look = T().look_at(origin=[0, 0, high], target=[0, 0, high + 1], up=[0, 1, 0])
    lamp = {
        "type": "rectangle",
        "to_world": T().translate([0, 0, 0.3]).scale([2, 1.5, 1]),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
    }
    light = {}
    for name, depth in (("straight", 2), ("all", 60)):
        described = {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth, "rr_depth": 60},
            "sensor": {
                "type": "orthographic",
                "near_clip": 1e-3,
                "to_world": look @ T().scale([HALF, HALF, 1]),
                "film": {
                    "type": "hdrfilm",
                    "width": SIDE,
                    "height": SIDE,
                    "rfilter": {"type": "box"},
                    "pixel_format": "rgb",
                },
                "sampler": {"type": "independent", "sample_count": 512},
            },
            "lamp": lamp,
            **room,
        }
        light[name] = np.array(mi.render(mi.load_dict(described))).mean(axis=2) / top
    more = light["all"] - light["straight"]
    # Averages over 4 x 4 cells reduce noise.
    even = more.reshape(SIDE // 4, 4, SIDE // 4, 4).mean(axis=(1, 3))
    return more.mean() / light["straight"].mean(), even.std() / even.mean()


def main() -> None:
    for sensor, (value, source) in constants(sys.argv[1]).items():
        print(f"{sensor}: constant {value:.3f} ({source})")
    alike = [(0.05, 0.05), (0.3, 0.3), (0.85, 0.85)]
    for room in (ball, dome, box):
        for walls, top in alike if room is ball else [*alike, (0.05, 0.3), (0.85, 0.3)]:
            part, uneven = bounced(room(walls, top), top)
            print(
                f"{room.__name__}, walls send back {walls:g}, what is looked at {top:g}: path traced {part:.3f}, "
                f"uneven by {100 * uneven:.0f} %; constant {walls / (1 - walls):.3f}"
            )


if __name__ == "__main__":
    main()
