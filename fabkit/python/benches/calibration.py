"""Calibrates R-Tac0s from rendered pins, halves or balls, each with a camera and light of its own.

python calibration.py [--trials N] [--captures N] [--seed N] [--fixture semi-domes|balls]

Prints by how far camera and surface are off, beside what the solver claims, who is told neither
pose nor light. Sets whose pictures are white in more than a tenth, which the solver warns of, are
counted apart. NEES is the error of the pose over its covariance, 6 on average where the claim is
right. Everything is simulated: elastic contact, the drawn bodies, the camera's noise; pins and dome
are where they should be. A trial takes half a minute of one core.
"""

import argparse
import csv
import json
import math
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

os.environ.setdefault("RAYON_NUM_THREADS", "1")

import cv2
import numpy as np

import fabkit
import fabkit.calibrate
import fabkit.depth
import fabkit.sim

SENSOR = "rtac0"
PINS = 5
# Nearer to each other pins are no two marks, mm.
APART_MM = 6.0
# Two holes lie behind the shell's rim.
HIDDEN = frozenset({24, 28})
# Balls at known places, as a robot presses them: their radius, mm, how many in a picture, how far
# apart; rings by their angle to the tip, and depths by name.
BALL_MM, BALLS, BALLS_APART_MM = 3.0, 3, 10.0
BALL_RINGS = ((0, 1), (25, 5), (45, 8), (62, 9))
BALL_DEPTHS_MM = {"deep": 1.0, "shallow": 0.6}
# How far a camera is from where it is drawn, one standard deviation: a part of its tolerances.
TURN_RAD, SHIFT_MM = math.radians(0.5), 0.3
# What the solver assumes of light in the layer (1/mm, mm), and how well it says it knows that.
SCATTER_PER_MM, SCATTER_LOG = 0.14, 0.7
SPREAD_MM, SPREAD_SIGMA_MM = 0.4, 0.15
# What an endless layer that scatters 1/mm sends back, and how much that differs.
LAYER_GREY, BRIGHT_LOG = 129.0, 0.15
GROUND_GREY = (10, 60)


def turned(vector):
    """Return the rotation about a vector by its length (Rodrigues)."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def vector_of(rotation):
    """Return the vector of a small turn."""
    return 0.5 * np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )


def constants(folder, light):
    document = {
        "format": "fabkit-fit-light",
        "version": 1,
        "captures": 3,
        "held_out_profile_rms_grey": 0.5,
        "constants": [{"name": name, "value": value} for name, value in light.items()],
    }
    path = folder / "light.json"
    path.write_text(json.dumps(document))
    return path


def ball_places(sensor):
    """Where balls are pressed: over the dome, to two depths, as landmarks' files have it."""
    surface = sensor.values.surface
    pins = []
    for ring, (polar_deg, count) in enumerate(BALL_RINGS):
        for place in range(count):
            polar, azimuth = math.radians(polar_deg), math.tau * (place + 0.5 * ring) / count
            out = np.array(
                [
                    math.sin(polar) * math.cos(azimuth),
                    math.sin(polar) * math.sin(azimuth),
                    math.cos(polar),
                ]
            )
            hole = 1 + len(pins) // len(BALL_DEPTHS_MM)
            for kind, depth_mm in BALL_DEPTHS_MM.items():
                contact = [0, 0, surface.wall_height] + (surface.radius - depth_mm) * out
                pins.append(
                    {
                        "hole": hole,
                        "kind": kind,
                        "tip_centre_in_sensor_mm": (contact + BALL_MM * out).tolist(),
                        "contact_in_sensor_mm": contact.tolist(),
                        "axis_in_sensor": (-out).tolist(),
                    }
                )
    return pins


def ball_file(folder, pins):
    document = {
        "format": "fabkit-pin-landmarks",
        "version": 1,
        "sensor": SENSOR,
        "fixture": "balls",
        "tip_radius_mm": BALL_MM,
        "pins": pins,
    }
    path = folder / "balls.json"
    path.write_text(json.dumps(document))
    return path


def captured_halves(folder, scene, light, landmarks, count, random):
    """Take the pictures; one half in each, on either side.

    Each half by itself, on nodes as fine as it asks for: those of a sensor that is kept ready are
    too rough for protrusions, and would pose as another light.
    """
    kinds = sorted({landmark["kind"] for landmark in landmarks})
    for kind in random.permutation(kinds)[:count]:
        seed = int(random.integers(1 << 31))
        picture = scene.capture([str(kind)], seed=seed, constants=light, allow_no_contact=True)
        grey = np.clip(np.rint(picture.grey), 0, 255).astype(np.uint8)
        cv2.imwrite(str(folder / f"{kind}.png"), grey)


@dataclass(frozen=True)
class Single:
    """What presses by itself, several in each picture: pins, or balls."""

    landmarks: list[dict]
    presser: Callable[[dict], object]
    in_picture: int
    apart_mm: float
    """Nearer to each other they are no two marks."""
    hidden: frozenset[int] = frozenset()
    """Holes that are left out."""

    def captured(self, folder, unit, count, random):
        """Take the pictures."""
        rows, asked = [], []
        for number in range(count):
            chosen = []
            while len(chosen) < self.in_picture:
                one = self.landmarks[random.integers(len(self.landmarks))]
                place = one["contact_in_sensor_mm"]
                others = [other["contact_in_sensor_mm"] for other in chosen]
                is_apart = all(math.dist(place, other) > self.apart_mm for other in others)
                if is_apart and one["hole"] not in self.hidden:
                    chosen.append(one)
            seed = int(random.integers(1 << 31))
            asked.append(fabkit.sim.Asked([self.presser(one) for one in chosen], seed=seed))
            rows += [(f"{number}.png", one["hole"], one["kind"]) for one in chosen]
        for number, image in enumerate(unit.press_all(asked).image):
            cv2.imwrite(str(folder / f"{number}.png"), image)
        with (folder / "captures.csv").open("w", newline="") as file:
            csv.writer(file).writerows([("file", "hole", "kind"), *rows])


def pins(sensor):
    landmarks = sensor.fixtures["pin-dome"].landmarks
    return Single(landmarks, lambda pin: f"pin-{pin['hole']}-{pin['kind']}", PINS, APART_MM, HIDDEN)


def balls(sensor):
    ball = fabkit.sim.ball(BALL_MM)
    return Single(
        ball_places(sensor),
        lambda place: ball.at(*place["tip_centre_in_sensor_mm"]),
        BALLS,
        BALLS_APART_MM,
    )


def trial(sensor, fixture, count, seed, *, has_own_sizes):
    """Return errors of one unit, and how sure they are said to be."""
    random = np.random.default_rng(seed)
    nominal = np.linalg.inv(fabkit.depth.Scene(sensor).sensor_from_camera)
    camera_from_sensor = nominal.copy()
    camera_from_sensor[:3, :3] = turned(random.normal(0, TURN_RAD, 3)) @ nominal[:3, :3]
    camera_from_sensor[:3, 3] += random.normal(0, SHIFT_MM, 3)
    scatter_per_mm = SCATTER_PER_MM * math.exp(random.normal(0, SCATTER_LOG))
    light = {
        "scatter_per_mm": scatter_per_mm,
        "layer_grey": LAYER_GREY / scatter_per_mm * math.exp(random.normal(0, BRIGHT_LOG)),
        "ground_grey": random.uniform(*GROUND_GREY),
        "spread_mm": max(random.normal(SPREAD_MM, SPREAD_SIGMA_MM), 0.1),
    }
    lens = fabkit.depth.Scene(sensor).camera
    own = {"unit": seed if has_own_sizes else None, "camera": lens, "pose": camera_from_sensor}
    truth = fabkit.depth.Scene(sensor, **own)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        light_file = constants(folder, light)
        unit = fabkit.sim.Sensor(sensor, constants=light_file, **own)
        landmarks = sensor.fixtures.get(fixture)
        if fixture == "semi-domes":
            captured_halves(folder, truth, light_file, landmarks.landmarks, count, random)
        else:
            single = balls(sensor) if fixture == "balls" else pins(sensor)
            single.captured(folder, unit, count, random)
            if fixture == "balls":
                landmarks = ball_file(folder, single.landmarks)
        cv2.imwrite(str(folder / "ref.png"), unit.press(seed=1).image)
        found = fabkit.calibrate.extrinsics(sensor, lens, folder, landmarks=landmarks)
    pose = found.camera_from_sensor
    off = np.concatenate(
        [
            vector_of(pose[:3, :3] @ camera_from_sensor[:3, :3].T),
            pose[:3, 3] - camera_from_sensor[:3, 3],
        ]
    )
    nees = off @ np.linalg.solve(found.covariance, off)
    seen = truth.cast().point_in_sensor
    solved = fabkit.depth.Scene(sensor, pose=found).cast(print_sigma_mm=0)
    # What a pixel shows in each, and how sure that is said to be: the surface does not move.
    apart = np.linalg.norm(solved.point_in_sensor - seen, axis=-1)
    both = np.isfinite(apart) & np.isfinite(solved.point_sigma_mm)
    apart, claimed = apart[both], solved.point_sigma_mm[both]
    return off, nees, off[5] / math.sqrt(found.covariance[5, 5]), apart, claimed, found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--trials", type=int, default=10)
    parser.add_argument("--captures", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--fixture", choices=("pin-dome", "semi-domes", "balls"), default="pin-dome"
    )
    parser.add_argument(
        "--sizes",
        action="store_true",
        help="units' parts, lamps and layers are off, too, as tolerances let them",
    )
    asked = parser.parse_args()
    sensor = fabkit.load(SENSOR)
    rows = []
    for seed in range(asked.seed, asked.seed + asked.trials):
        off, nees, in_z, apart, claimed, found = trial(
            sensor, asked.fixture, asked.captures, seed, has_own_sizes=asked.sizes
        )
        surface, sure = (math.sqrt((mm**2).mean()) for mm in (apart, claimed))
        is_white = any("saturated" in warning for warning in found.warnings)
        is_other = any("not the one that is drawn" in warning for warning in found.warnings)
        rows.append((nees, in_z, surface, sure, is_white))
        print(
            f"{seed}: NEES {nees:.1f}, z {off[5]:+.3f} mm ({in_z:+.1f} sigma), "
            f"surface {surface:.4f} mm rms of {sure:.4f}, median {np.median(apart):.4f}; "
            f"held out {found.held_out_rms_px:.2f} px",
            "; over-exposed" if is_white else "",
            "; not the drawn unit" if is_other else "",
            flush=True,
        )
    summary("all", rows)
    summary("not over-exposed", [row for row in rows if not row[4]])


def summary(which, rows):
    """Print what all trials of a kind come to."""
    nees, in_z, surface, sure, _ = np.array(rows, dtype=float).reshape(-1, 5).T
    if not len(nees):
        return
    rms, claimed = (math.sqrt((mm**2).mean()) for mm in (surface, sure))
    print(
        f"{len(nees)} trials, {which}: NEES {nees.mean():.2f}, median {np.median(nees):.2f}; "
        f"z beyond 3 sigma in {int((np.abs(in_z) > 3).sum())}; "
        f"surface {rms:.4f} mm rms where {claimed:.4f} is claimed, median {np.median(surface):.4f}"
    )


if __name__ == "__main__":
    main()
