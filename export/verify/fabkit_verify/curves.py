"""Segments of profiles: lines, arcs and elliptic arcs, by angles and as polylines."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

Point = tuple[float, float]


@dataclass(frozen=True)
class Piece:
    """One segment of a path. An arc runs from the angle `first` by `turn`, rad, counter-clockwise if
    positive."""

    kind: str
    start: Point
    to: Point
    centre: Point = (0.0, 0.0)
    semi_axes_mm: Point = (0.0, 0.0)
    first: float = 0.0
    turn: float = 0.0

    def at(self, fraction: float) -> Point:
        """Returns a point of the piece; 0 is its start and 1 its end, exactly."""
        if fraction <= 0.0 or fraction >= 1.0:
            return self.start if fraction <= 0.0 else self.to
        if self.kind == "line":
            return tuple(a + fraction * (b - a) for a, b in zip(self.start, self.to))
        angle = self.first + fraction * self.turn
        return (
            self.centre[0] + self.semi_axes_mm[0] * math.cos(angle),
            self.centre[1] + self.semi_axes_mm[1] * math.sin(angle),
        )


def pieces(path: dict[str, Any]) -> Iterator[Piece]:
    """Yields the segments of a path in order."""
    here = tuple(path["start"])
    for segment in path["segments"]:
        ((kind, how),) = segment.items()
        to = tuple(how["to"])
        if kind == "line":
            yield Piece(kind, here, to)
        else:
            centre = tuple(how["centre"])
            radius = math.dist(here, centre)
            axes = tuple(how.get("semi_axes_mm", (radius, radius)))
            first, last = (
                math.atan2((p[1] - centre[1]) / axes[1], (p[0] - centre[0]) / axes[0])
                for p in (here, to)
            )
            turn = (last - first if how["ccw"] else first - last) % math.tau
            # Equal ends mean a whole turn, not none.
            turn = turn if turn > 1e-12 else math.tau
            yield Piece(kind, here, to, centre, axes, first, turn if how["ccw"] else -turn)
        here = to


def steps_of_turn(turn: float, radius_mm: float, chord_mm: float) -> int:
    """Computes the number of chords for a circular arc so that none is farther than `chord_mm` from it."""
    if radius_mm <= chord_mm:
        return max(1, math.ceil(abs(turn) / (math.pi / 2.0)))
    return max(1, math.ceil(abs(turn) / (2.0 * math.acos(1.0 - chord_mm / radius_mm))))


def polyline(path: dict[str, Any], chord_mm: float) -> list[Point]:
    """Approximates a path by points, the first not repeated; no chord is farther than `chord_mm` from it."""
    points: list[Point] = []
    for piece in pieces(path):
        # Equal steps of the eccentric angle are chords of a circle with the longer half axis, which a
        # contraction maps to the ellipse: chord errors do not grow.
        steps = 1
        if piece.kind != "line":
            steps = steps_of_turn(piece.turn, max(piece.semi_axes_mm), chord_mm)
        points += [piece.at(i / steps) for i in range(steps)]
    return points
