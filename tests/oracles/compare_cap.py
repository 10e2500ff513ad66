"""Compares a pressed and sheared dome of gel with published node displacements of a commercial program.

    cargo build --release -p fabkit-elastic --example press_json
    python compare_cap.py target/release/examples/press_json DIR [--poisson 0.44]

DIR contains the six files that Taxim published (`0705_dome_node_dz_0.3_x.txt` and so on): a spherical cap, 33.6 mm
wide and 5.5 mm high, pressed (`dz`), and pressed and sheared, at its tip by an indenter that is too small for its
mesh; nodes move by 0.117 mm at most, in `dz` sideways too. Neither the material nor the pin's shape is published, so
Poisson's ratio is an argument, and three numbers are fitted: the amounts of a unit press and of unit shears along x
and y. Everything else must follow: beyond 0.8 mm from the tip, displacements agree within 5 % of the largest.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

Array = np.ndarray

RADIUS_MM, HEIGHT_MM = 16.8, 5.5
TIP_MM = np.array([30.544, 35.09])
# Nodes nearer to the tip touch the pin, whose shape is not known.
OUTSIDE_MM = 0.8
AGREEMENT = 0.05
PRESS_MM, SHEAR_MM = 0.02, 0.002


def published(folder: Path, name: str) -> tuple[Array, Array]:
    """Reads node positions, mm across from the tip, and displacements, mm, with z upwards."""
    tables = [np.loadtxt(folder / f"0705_dome_node_{name}_0.3_{axis}.txt", skiprows=1) for axis in "xyz"]
    tables = [table[np.argsort(table[:, 0])] for table in tables]
    moved = 1e3 * np.array([table[:, 4] for table in tables]).T
    return 1e3 * tables[0][:, 1:3] - TIP_MM, moved * [1.0, 1.0, -1.0]


def units(example: str, poisson: float, places: Array) -> Array:
    """Computes displacements of a unit press, and of unit shears along x and y, in three columns."""
    asked = {
        "radius_mm": RADIUS_MM,
        "cap_mm": HEIGHT_MM,
        "layers": [{"young_mpa": 0.2, "poisson": poisson, "thickness_mm": HEIGHT_MM}],
        "presser": {"ball_mm": 1.0},
        "depth_mm": PRESS_MM,
        "spacing_mm": 0.12,
        "reach_mm": 3.0,
        "max_harmonic": 12,
        "probes_mm": places.tolist(),
    }

    def displacements(**more: object) -> Array:
        text = json.dumps(asked | more)
        answer = subprocess.run([example], input=text, check=True, capture_output=True, text=True)
        return np.array(json.loads(answer.stdout)["probes"]).ravel()

    pressed = displacements()
    sheared = [displacements(friction=50.0, shear_mm=way) for way in ([SHEAR_MM, 0.0], [0.0, SHEAR_MM])]
    return np.array([pressed, *(both - pressed for both in sheared)]).T


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("example", help="the example press_json, built")
    parser.add_argument("folder", type=Path, help="where the published files are")
    parser.add_argument("--poisson", type=float, default=0.44)
    asked = parser.parse_args()
    agrees = True
    for name in ("dz", "dxdz"):
        places, moved = published(asked.folder, name)
        largest_mm = float(np.linalg.norm(moved, axis=1).max())
        radii = np.hypot(*places.T)
        outside = (radii > OUTSIDE_MM) & (radii < RADIUS_MM)
        by_unit = units(asked.example, asked.poisson, places[outside])
        amounts, *_ = np.linalg.lstsq(by_unit, moved[outside].ravel(), rcond=None)
        apart = np.linalg.norm((by_unit @ amounts).reshape(-1, 3) - moved[outside], axis=1)
        worst = int(apart.argmax())
        is_close = apart[worst] < AGREEMENT * largest_mm
        agrees &= bool(is_close)
        print(
            f"{name}: {outside.sum()} nodes, largest displacement {largest_mm:.3f} mm; "
            f"apart by {apart[worst] / largest_mm:.1%} of it at most, {radii[outside][worst]:.2f} mm from the "
            "tip, "
            f"{np.sqrt((apart**2).mean()) / largest_mm:.2%} in the root mean square: "
            f"{'ok' if is_close else 'FAILED'}"
        )
    return 0 if agrees else 1


if __name__ == "__main__":
    sys.exit(main())
