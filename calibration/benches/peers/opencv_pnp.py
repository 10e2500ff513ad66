"""Solves poses of a fisheye camera with OpenCV.

Standard input: one JSON line with `camera_matrix` (3 x 3), `distortion` (4), `trials`, each with
`points` (N x 3, mm) and `pixels` (N x 2), and how many `runs` of all trials; the fastest counts. Standard output: one JSON line with, for each method, the
microseconds of one solve and the positions of the camera, null where it found none.
"""

import json
import sys
import time

import cv2
import numpy as np

METHODS = {"SQPNP": cv2.SOLVEPNP_SQPNP, "iterative": cv2.SOLVEPNP_ITERATIVE}


def position(rvec, tvec):
    rotation, _ = cv2.Rodrigues(rvec)
    return (-rotation.T @ tvec).ravel().tolist()


def main():
    scene = json.loads(sys.stdin.readline())
    matrix = np.array(scene["camera_matrix"])
    distortion = np.array(scene["distortion"])
    trials = [
        (np.array(t["points"]).reshape(-1, 1, 3), np.array(t["pixels"]).reshape(-1, 1, 2))
        for t in scene["trials"]
    ]
    results = {"opencv": cv2.__version__, "methods": {}}
    for name, flag in METHODS.items():
        micros = float("inf")
        for _ in range(scene["runs"]):
            poses = []
            start = time.perf_counter()
            for points, pixels in trials:
                try:
                    poses.append(
                        cv2.fisheye.solvePnP(points, pixels, matrix, distortion, flags=flag)
                    )
                except cv2.error:
                    poses.append((False, None, None))
            micros = min(micros, (time.perf_counter() - start) * 1e6 / len(trials))
        positions = [
            position(rvec, tvec) if found and np.isfinite(tvec).all() else None
            for found, rvec, tvec in poses
        ]
        results["methods"][name] = {"micros": micros, "positions": positions}
    print(json.dumps(results))


main()
