"""Solves poses of a fisheye camera with OpenCV.

Standard input: one JSON line with `camera_matrix` (3 x 3), `distortion` (4), and `trials`, each with
`points` (N x 3, mm) and `pixels` (N x 2). Standard output: one JSON line with, for each method, the
median microseconds of one solve and the positions of the camera, null where it found none.
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
        poses, micros = [], []
        for points, pixels in trials:
            start = time.perf_counter()
            try:
                pose = cv2.fisheye.solvePnP(points, pixels, matrix, distortion, flags=flag)
            except cv2.error:
                pose = (False, None, None)
            micros.append((time.perf_counter() - start) * 1e6)
            poses.append(pose)
        positions = [
            position(rvec, tvec) if found and np.isfinite(tvec).all() else None
            for found, rvec, tvec in poses
        ]
        results["methods"][name] = {"micros": float(np.median(micros)), "positions": positions}
    print(json.dumps(results))


main()
