"""Real roots of quadratic and quartic polynomials, for many rays at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Relative imaginary part below which a root counts as real: rounding, or two real roots that nearly coincide. A false
# root does no harm, because a point between two roots decides whether a stretch is inside.
NEARLY_REAL = 1e-4


def quadratic(a: Array, half_b: Array, c: Array) -> Array:
    """Returns both roots of `a t^2 + 2 half_b t + c`, (rays, 2); NaN if they are not real."""
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(half_b * half_b - a * c)
        # The form of each root without cancellation.
        q = -(half_b + np.copysign(root, half_b))
        return np.stack([q / a, c / q], axis=-1)


def quartic(coefficients: Array) -> Array:
    """Returns the nearly real roots of quartic polynomials, (rays, 4); NaN for the others.

    `coefficients` are (rays, 5) from the highest power down; the highest must not be 0. The roots are eigenvalues of
    companion matrices, refined by Newton's method.
    """
    monic = coefficients / coefficients[:, :1]
    companion = np.zeros((len(monic), 4, 4))
    companion[:, 1:, :3] = np.eye(3)
    companion[:, :, 3] = -monic[:, :0:-1]
    found = np.linalg.eigvals(companion)
    size = 1.0 + np.abs(found)
    roots = np.where(np.abs(found.imag) < NEARLY_REAL * size, found.real, np.nan)
    for _ in range(4):
        value, slope = np.ones_like(roots), np.zeros_like(roots)
        for k in range(1, 5):
            slope = slope * roots + value
            value = value * roots + monic[:, k : k + 1]
        with np.errstate(invalid="ignore", divide="ignore"):
            step = value / slope
            roots = np.where(np.abs(step) < 1e-2 * size, roots - step, roots)
    return roots
