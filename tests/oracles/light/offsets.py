"""Distances from an ellipsoid of revolution, and crossings of lines with its parallel surfaces."""

from __future__ import annotations

import numpy as np

from .roots import Array, quadratic

# Largest number of steps of Newton's method.
MOST_STEPS = 80


class Ellipse:
    """An ellipsoid of revolution around z."""

    def __init__(self, equatorial_mm: float, polar_mm: float):
        self.a, self.b = equatorial_mm, polar_mm

    def distance(self, p: Array) -> tuple[Array, Array]:
        """Computes signed distances of points (..., 3), negative inside, and unit directions out of the ellipsoid.

        The nearest point to (u, z) is (a^2 u / (s + a^2), b^2 z / (s + b^2)), for the s beyond the poles of its
        equation at which that point is on the ellipse. The equation is convex there, so Newton's method does not
        overshoot if it starts on the side of the poles.
        """
        a2, b2 = self.a**2, self.b**2
        u, z = np.hypot(p[..., 0], p[..., 1]), np.abs(p[..., 2])
        s = np.maximum(self.a * u - a2, self.b * z - b2)
        # For a point in the plane z = 0 deep inside, s would be at a pole.
        s = np.maximum(s, -min(a2, b2) * (1.0 - 1e-12))
        for _ in range(MOST_STEPS):
            x, y = self.a * u / (s + a2), self.b * z / (s + b2)
            value = x * x + y * y - 1.0
            slope = -2.0 * (x * x / (s + a2) + y * y / (s + b2))
            with np.errstate(divide="ignore", invalid="ignore"):
                step = np.where(slope < 0.0, value / slope, 0.0)
            s = s - step
            if np.all(np.abs(step) <= 1e-15 * (a2 + np.abs(s))):
                break
        nearest = np.stack([a2 * u / (s + a2), b2 * z / (s + b2)], axis=-1)
        out = nearest / [a2, b2]
        out = out / np.linalg.norm(out, axis=-1, keepdims=True)
        away = (u - nearest[..., 0]) * out[..., 0] + (z - nearest[..., 1]) * out[..., 1]
        share = out[..., 0] / np.maximum(u, 1e-300)
        z_out = np.copysign(out[..., 1], p[..., 2])
        return away, np.stack([p[..., 0] * share, p[..., 1] * share, z_out], axis=-1)

    def crossings(self, o: Array, d: Array, offset: float) -> Array:
        """Returns the two lengths along unit rays at which their distance is `offset`; (rays, 2), NaN for none.

        The distance is convex along a line, so there are at most two, one on each side of its minimum.
        """
        result = np.full((len(o), 2), np.nan)
        # A bounding sphere limits the search.
        wide = max(self.a, self.b) + max(offset, 0.0) + 1.0
        foot = -(o * d).sum(-1)
        near = o + foot[:, None] * d
        half = np.sqrt(np.maximum(wide**2 - (near * near).sum(-1), 0.0))
        lowest = self._lowest(o, d, foot, half, offset)
        at = np.flatnonzero(~np.isnan(lowest))
        for side, sign in enumerate([-1.0, 1.0]):
            outside = foot[at] + sign * half[at]
            result[at, side] = self._between(o[at], d[at], lowest[at], outside, offset)
        return result

    def _lowest(self, o: Array, d: Array, foot: Array, half: Array, offset: float) -> Array:
        """Returns a length at which a ray is inside; NaN if it never is."""
        axes = np.array([self.a + offset, self.a + offset, self.b + offset])
        scaled_o, scaled_d = o / axes, d / axes
        guess = -(scaled_o * scaled_d).sum(-1) / (scaled_d * scaled_d).sum(-1)
        away, _ = self.distance(o + guess[:, None] * d)
        # Rays for which the first guess is outside: bisect towards the minimum by the sign of the slope.
        open_ = np.flatnonzero((away >= offset) & (half > 0.0))
        low, high = foot[open_] - half[open_], foot[open_] + half[open_]
        for _ in range(60):
            middle = 0.5 * (low + high)
            _, out = self.distance(o[open_] + middle[:, None] * d[open_])
            rises = (out * d[open_]).sum(-1) > 0.0
            low, high = np.where(rises, low, middle), np.where(rises, middle, high)
        guess[open_] = 0.5 * (low + high)
        away[open_], _ = self.distance(o[open_] + guess[open_, None] * d[open_])
        return np.where(away < offset, guess, np.nan)

    def _between(self, o: Array, d: Array, inner: Array, outer: Array, offset: float) -> Array:
        """Finds the root between a length inside and one outside, by Newton's method within the bracket."""
        axes = np.array([self.a + offset, self.a + offset, self.b + offset])
        scaled_o, scaled_d = o / axes, d / axes
        half_b, a = (scaled_o * scaled_d).sum(-1), (scaled_d * scaled_d).sum(-1)
        both = quadratic(a, half_b, (scaled_o * scaled_o).sum(-1) - 1.0)
        start = np.where(outer < inner, both.min(-1), both.max(-1))
        low, high = np.minimum(inner, outer), np.maximum(inner, outer)
        t = np.where((start > low) & (start < high), start, 0.5 * (inner + outer))
        for _ in range(MOST_STEPS):
            away, out = self.distance(o + t[:, None] * d)
            is_in = away < offset
            inner, outer = np.where(is_in, t, inner), np.where(is_in, outer, t)
            with np.errstate(divide="ignore", invalid="ignore"):
                new = t - (away - offset) / (out * d).sum(-1)
            low, high = np.minimum(inner, outer), np.maximum(inner, outer)
            new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
            step, t = np.abs(new - t), new
            if np.all(step < 1e-13 * (1.0 + np.abs(t))):
                break
        return t
