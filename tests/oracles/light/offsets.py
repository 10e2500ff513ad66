"""The distance from an ellipsoid of revolution, and where lines are so far from it."""

from __future__ import annotations

import numpy as np

from .roots import Array, quadratic

# Steps that halve a bracket, and of Newton's method for the nearest point.
MOST_STEPS = 80


class Ellipse:
    """Turned around z."""

    def __init__(self, equatorial_mm: float, polar_mm: float):
        self.a, self.b = equatorial_mm, polar_mm

    def distance(self, p: Array) -> tuple[Array, Array]:
        """Signed distances of points (..., 3), below 0 inside, and unit directions out of the ellipsoid.

        The nearest point of a point (u, z) is (a^2 u / (s + a^2), b^2 z / (s + b^2)), for the s beyond the poles of
        its equation at which that lies on the ellipse. The equation is convex there, so that Newton's
        method never passes the root when it begins on its near side.
        """
        a2, b2 = self.a**2, self.b**2
        u, z = np.hypot(p[..., 0], p[..., 1]), np.abs(p[..., 2])
        s = np.maximum(self.a * u - a2, self.b * z - b2)
        # A point of the plane z = 0 deep inside has s at a pole.
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
        """The two lengths along unit rays at which they are so far from it; (rays, 2), NaN for none.

        The distance is convex along a line, so that there are two at most, one on each side of where it is
        least.
        """
        result = np.full((len(o), 2), np.nan)
        # A box of spheres around: the ends of what must be looked at.
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
        """A length at which a ray is inside; NaN where there is none."""
        axes = np.array([self.a + offset, self.a + offset, self.b + offset])
        scaled_o, scaled_d = o / axes, d / axes
        guess = -(scaled_o * scaled_d).sum(-1) / (scaled_d * scaled_d).sum(-1)
        away, _ = self.distance(o + guess[:, None] * d)
        # Those that the first guess does not settle: halve where the slope says so.
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
        """The root between a length inside and one outside, by Newton's method kept within its bracket."""
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
