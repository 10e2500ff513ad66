"""Directions of pixels, by the lens model."""

from __future__ import annotations

from typing import Any

import numpy as np

from .roots import Array


def directions(camera: dict[str, Any], column: Array, row: Array) -> Array:
    """Computes unit directions of pixels in the camera frame: x along rows, y along columns, z ahead.

    It inverts Kannala and Brandt's polynomial of the angle theta to the axis, r = theta (1 + k1 theta^2 + ... + k4
    theta^8), by Newton's method.
    """
    if camera["lens"] != "kannala-brandt":
        raise ValueError(f"unknown lens: {camera['lens']}")
    of = camera["parameters"]
    x = (column - of["cx_px"]) / of["fx_px"]
    y = (row - of["cy_px"]) / of["fy_px"]
    r = np.hypot(x, y)
    terms = np.array([of["k4"], of["k3"], of["k2"], of["k1"], 1.0])
    theta = r.copy()
    if terms[:-1].any():
        for _ in range(50):
            squared = theta * theta
            value = theta * np.polyval(terms, squared) - r
            theta = theta - value / np.polyval(terms * [9.0, 7.0, 5.0, 3.0, 1.0], squared)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(r > 0.0, np.sin(theta) / r, 1.0)
    return np.stack([x * share, y * share, np.cos(theta)], axis=-1)
