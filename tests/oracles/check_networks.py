"""Compares depth networks on the same simulated presses, which are held out of the bench's own training.

    python check_networks.py NETWORK.onnx...

A network without a card beside it counts as R-Tac0's published one. Errors are over pixels in contact, and over all
pixels that the first network evaluates. Needs the Python packages fabkit and fabkit-bench. On demand: networks are not
in this repository; `python -m fabkit_bench.network rtac0 -o NETWORK.onnx` trains one.
"""

import sys

import fabkit.sim as sim
import numpy as np
from fabkit.designs import load
from fabkit_bench.network import maps, presses


def main() -> None:
    networks = sys.argv[1:]
    design = load("rtac0")
    sensor = sim.Sensor(design, spacing_mm=0.3)
    rest = sensor.press(seed=0)
    _, held_out = presses(design, 0)
    errors: dict[str, list[list[float]]] = {name: [] for name in [*networks, "nothing"]}
    shares: dict[str, list[float]] = {name: [] for name in errors}
    for seen in maps(sensor, held_out, rest, 5000):
        looked_at = None
        for name in errors:
            depth_mm, touched = np.zeros_like(seen.depth_mm), looked_at
            if name != "nothing":
                depth_mm, touched = sensor.reconstruct(seen.image, rest.image, network=name)
            looked_at = touched if looked_at is None else looked_at
            error = np.abs(depth_mm - seen.depth_mm)
            near = 100 * (error[seen.contact] < 0.1).mean()
            errors[name].append([error[seen.contact].mean(), near, error[looked_at].mean()])
            shares[name].append(100 * touched.mean())
    print(f"{len(held_out)} presses: L1 where something presses, mm; below 0.1 mm; L1 of all; touched")
    for name, found in errors.items():
        contact_mm, near, all_mm = np.mean(found, axis=0)
        share, most = np.mean(shares[name]), np.max(shares[name])
        print(f"{name}: {contact_mm:.4f}, {near:.0f} %, {all_mm:.4f}, {share:.1f} % (up to {most:.1f} %)")


if __name__ == "__main__":
    main()
