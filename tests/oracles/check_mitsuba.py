"""Compares direct light with that of the path tracer Mitsuba 3.

    python check_mitsuba.py PATH_TO_THE_EXAMPLE_lamps_json

The example prints the irradiance at 40 x 40 cells of a plane 10 mm above light sources; Mitsuba 3 renders the same
scenes with a camera just below the plane. Absolute values are compared, without a fitted factor. On demand:
`pip install mitsuba numpy`.
"""

import json
import subprocess
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f

HALF, SIDE, HEIGHT = 10.0, 40, 10.0
# Reflectance of the plane: so small that light which it reflects and receives again is negligible.
SENDS = 0.01
# Scene without shadows, averaged over blocks: it is noisy, because few paths reach a light source through glass.
SMOOTH = "into glass"


def lamp(x: float, y: float, color: list[float]) -> dict:
    return {
        "type": "rectangle",
        "to_world": T().translate([x, y, 0]).scale([2, 1.5, 1]),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": color}},
    }


def scene(others: dict, lamps: list[dict], integrator: dict, samples: int) -> np.ndarray:
    # The camera looks along +z: x decreases to the right in the image.
    look = T().look_at(origin=[0, 0, HEIGHT - 0.05], target=[0, 0, HEIGHT], up=[0, 1, 0])
    described = {
        "type": "scene",
        "integrator": integrator,
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
            "sampler": {"type": "independent", "sample_count": samples},
        },
        "plane": {
            "type": "rectangle",
            # Its front faces down.
            "to_world": T().translate([0, 0, HEIGHT]).rotate([1, 0, 0], 180).scale([40, 40, 1]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": SENDS}},
        },
        **{f"lamp{i}": lamp for i, lamp in enumerate(lamps)},
        **others,
    }
    picture = np.array(mi.render(mi.load_dict(described)))
    # Reverse rows (y is up) and columns (x decreases), and convert radiance to irradiance.
    return np.pi / SENDS * picture[::-1, ::-1]


def blocks(light: np.ndarray) -> np.ndarray:
    """Averages 4 x 4 cells."""
    return light.reshape(SIDE // 4, 4, SIDE // 4, 4, 3).mean(axis=(1, 3))


def black(shape: dict) -> dict:
    return {**shape, "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}


def main() -> None:
    ours = json.loads(subprocess.run([sys.argv[1]], capture_output=True, check=True).stdout)
    white = [lamp(0, 0, [1, 1, 1])]
    around = [
        lamp(8, 0, [1, 0.1, 0]),
        lamp(-4, 7, [0, 1, 0.2]),
        lamp(-4, -7, [0.1, 0, 1]),
    ]
    plate = T().translate([1, 0, 4.25]).scale([1.5, 1.5, 0.25])
    glass = {
        "type": "cube",
        "to_world": T().translate([0, 0, 54]).scale([200, 200, 50]),
        "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0},
    }
    direct, path = {"type": "direct"}, {"type": "path", "max_depth": 8}
    scenes = {
        "open": ({}, white, direct, 8192),
        "plate in the way": ({"black": black({"type": "cube", "to_world": plate})}, white, direct, 1024),
        "three colours round a ball": (
            {"black": black({"type": "sphere", "center": [0, 0, 6], "radius": 2.0})},
            around,
            direct,
            16384,
        ),
        "into glass": ({"glass": glass}, white, path, 65536),
    }
    wrong = []
    for name, what in scenes.items():
        theirs = scene(*what)
        mine = np.array(ours[name]).reshape(SIDE, SIDE, 3)
        if name == SMOOTH:
            mine, theirs = (blocks(light) for light in (mine, theirs))
        rms = np.sqrt(np.mean((mine - theirs) ** 2)) / theirs.mean()
        print(f"{name}: {100 * rms:.2f} % rms of the mean, all light {mine.sum() / theirs.sum():.4f} of theirs")
        if rms > 0.02:
            wrong.append(name)
    if wrong:
        sys.exit(f"more than 2 % off: {', '.join(wrong)}")


if __name__ == "__main__":
    main()
