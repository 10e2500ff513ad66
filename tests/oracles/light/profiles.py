"""Profiles: plane regions bounded by lines and arcs, to extrude or revolve."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from .roots import Array, quadratic

# Segments extend beyond their ends by this, mm, so that no line passes between two of them.
SLACK_MM = 1e-9


class Segment:
    """A line (without axes) or an arc of an ellipse with its axes along those of the plane."""

    def __init__(self, kind: str, start: list[float], how: dict[str, Any]):
        self.start, self.end = np.array(start), np.array(how["to"])
        self.is_line = kind == "line"
        self.centre, self.axes, self.ccw = np.zeros(2), np.ones(2), True
        if not self.is_line:
            self.centre, self.ccw = np.array(how["centre"]), bool(how["ccw"])
            radius = float(np.hypot(*(self.start - self.centre)))
            self.axes = np.array(how.get("semi_axes_mm", [radius, radius]))

    def bounds(self) -> Array:
        if self.is_line:
            return np.stack([np.minimum(self.start, self.end), np.maximum(self.start, self.end)])
        # Box of the whole ellipse: it may be too large, not too small.
        return np.stack([self.centre - self.axes, self.centre + self.axes])

    def bulge(self, p: Array) -> Array:
        """Returns for points (..., 2) whether they are between the arc and its chord."""
        if self.is_line:
            return np.zeros(p.shape[:-1], bool)
        q = (p - self.centre) / self.axes
        is_in = (q * q).sum(-1) < 1.0
        if np.hypot(*(self.end - self.start)) < SLACK_MM:
            return is_in
        # A counter-clockwise arc is on the right of its chord.
        return is_in & (self.is_left(p) != self.ccw)

    def is_left(self, p: Array) -> Array:
        """Returns whether points are on the left of the chord.

        Points on it count as moved up a little, and to the right by less, so that the even-odd rule and arcs treat
        them in the same way.
        """
        x, y = self.end - self.start
        left = x * (p[..., 1] - self.start[1]) - y * (p[..., 0] - self.start[0])
        return (left > 0.0) | ((left == 0.0) & ((x > 0.0) | ((x == 0.0) & (y < 0.0))))

    def _beyond(self, p: Array) -> Array:
        """Returns the distance of points from the chord, positive on the arc's side; infinite for a full turn."""
        chord = self.end - self.start
        length = np.hypot(*chord)
        if length < SLACK_MM:
            return np.full(p.shape[:-1], np.inf)
        left = chord[0] * (p[..., 1] - self.start[1]) - chord[1] * (p[..., 0] - self.start[0])
        return (-left if self.ccw else left) / length

    def holds(self, p: Array) -> Array:
        """Returns whether points (..., 2) of the whole line or ellipse belong to the segment, with some slack."""
        if not self.is_line:
            return self._beyond(p) > -SLACK_MM
        chord = self.end - self.start
        along = ((p - self.start) * chord).sum(-1) / np.hypot(*chord)
        return (along > -SLACK_MM) & (along < np.hypot(*chord) + SLACK_MM)

    def normal(self, p: Array) -> Array:
        if self.is_line:
            along = self.end - self.start
            n = np.broadcast_to([along[1], -along[0]], p.shape)
        else:
            n = (p - self.centre) / self.axes**2
        return n / np.linalg.norm(n, axis=-1, keepdims=True)


class Outline:
    """All paths of a profile; a segment's number is that of its face."""

    def __init__(self, profile: dict[str, Any]):
        self.segments: list[Segment] = []
        for path in [profile["outer"], *profile.get("holes", [])]:
            here = path["start"]
            for segment in path["segments"]:
                ((kind, how),) = segment.items()
                self.segments.append(Segment(kind, here, how))
                here = how["to"]
        boxes = np.array([segment.bounds() for segment in self.segments])
        self.bounds = np.stack([boxes[:, 0].min(0), boxes[:, 1].max(0)])
        self.arcs = [segment for segment in self.segments if not segment.is_line]

    def inside(self, p: Array) -> Array:
        """Returns whether points are inside: the even-odd rule for the chords, then toggled between arc and chord."""
        y = p[..., 1]
        result = np.zeros(y.shape, bool)
        for segment in self.segments:
            y0, y1 = segment.start[1], segment.end[1]
            if y0 != y1:
                result ^= ((y0 > y) != (y1 > y)) & (segment.is_left(p) == (y1 > y0))
        for arc in self.arcs:
            result ^= arc.bulge(p)
        return result

    def normal(self, p: Array, face: Array) -> Array:
        """Returns unit normals at points (n, 2) on segments (n,)."""
        result = np.ones_like(p)
        for number in np.unique(face):
            if 0 <= number < len(self.segments):
                at = face == number
                result[at] = self.segments[number].normal(p[at])
        return result

    def crossings(self, o: Array, d: Array) -> tuple[Array, Array]:
        """Returns the lengths at which lines of the plane may cross segments, (rays, k), and the segments, (k,)."""
        found: list[Array] = []
        faces: list[int] = []
        for number, segment in enumerate(self.segments):
            if segment.is_line:
                t = _of_line(segment, o, d)
            else:
                q, e = (o - segment.centre) / segment.axes, d / segment.axes
                t = quadratic((e * e).sum(-1), (q * e).sum(-1), (q * q).sum(-1) - 1.0)
            with np.errstate(invalid="ignore"):
                found.append(np.where(segment.holds(o[:, None] + t[..., None] * d[:, None]), t, np.nan))
            faces += [number] * t.shape[1]
        return np.concatenate(found, axis=-1), np.array(faces)


def _of_line(segment: Segment, o: Array, d: Array) -> Array:
    along = segment.end - segment.start
    off = segment.start - o
    with np.errstate(divide="ignore", invalid="ignore"):
        across = d[:, 0] * along[1] - d[:, 1] * along[0]
        return ((off[:, 0] * along[1] - off[:, 1] * along[0]) / across)[:, None]


class Turned:
    """An outline in the half plane (distance from z, z), revolved around z."""

    def __init__(self, outline: Outline, ellipse: Callable[..., Array]):
        self.outline, self.ellipse = outline, ellipse

    def crossings(self, o: Array, d: Array) -> tuple[Array, Array]:
        found: list[Array] = []
        faces: list[int] = []
        for number, segment in enumerate(self.outline.segments):
            if not segment.is_line:
                t = self.ellipse(o, d, segment.centre.tolist(), segment.axes.tolist())
            elif max(segment.start[0], segment.end[0]) <= 0.0:
                continue  # A segment on the axis has no surface.
            else:
                t = self._of_line(segment, o, d)
            t = self._on(segment, t, o, d)
            found.append(t)
            faces += [number] * t.shape[1]
        return np.concatenate(found, axis=-1), np.array(faces)

    @staticmethod
    def _of_line(segment: Segment, o: Array, d: Array) -> Array:
        (u0, z0), (u1, z1) = segment.start, segment.end
        with np.errstate(divide="ignore", invalid="ignore"):
            if z0 == z1:
                return ((z0 - o[:, 2]) / d[:, 2])[:, None]
            slope = (u1 - u0) / (z1 - z0)
            reach, grows = u0 + slope * (o[:, 2] - z0), slope * d[:, 2]
            a = d[:, 0] ** 2 + d[:, 1] ** 2 - grows**2
            b = o[:, 0] * d[:, 0] + o[:, 1] * d[:, 1] - reach * grows
            return quadratic(a, b, o[:, 0] ** 2 + o[:, 1] ** 2 - reach**2)

    @staticmethod
    def _on(segment: Segment, t: Array, o: Array, d: Array) -> Array:
        """Removes crossings that are not on the segment itself, or are on its mirror image across the axis."""
        with np.errstate(invalid="ignore"):
            p = o[:, None] + t[..., None] * d[:, None]
            flat = np.stack([np.hypot(p[..., 0], p[..., 1]), p[..., 2]], axis=-1)
            return np.where(segment.holds(flat), t, np.nan)
