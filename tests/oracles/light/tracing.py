"""Tracing of many rays from medium to medium, by the model of docs/light.md."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .lens import directions
from .roots import Array
from .solids import Forest, Indices, Node, Rays, Spans

# Faces nearer to each other than this along a ray touch, mm: docs/light.md.
TOUCH_MM = 1e-7
# Stretches that end nearer to a ray's origin are behind it, mm.
START_MM = 1e-9
# Largest number of refractions of a ray.
MOST_BENDS = 64
# Refractive index of air.
AIR = 1.0
# Indices into `seen_by_names` for the end of a ray.
NOTHING, SURFACE, FIRST_BODY = 0, 1, 2


@dataclass
class Item:
    """One body at one pose."""

    node: Node
    part: str
    # Refractive index.
    index: float
    is_skin: bool
    # Index into `seen_by_names`.
    name: int


@dataclass
class Paths:
    """Traced rays: the body that each sees, the point (NaN for nothing), and the number of refractions."""

    seen_by: Indices
    point: Array
    bends: Indices
    # Corners of each path, starting at the pupil, one array per refraction; NaN for rays that ended before.
    corners: list[Array]


@dataclass
class _Walk:
    """Rays cut into pieces between crossings of all items, sorted by ray, then by distance."""

    ray: Indices
    t: Array
    is_first: Array
    length: Array
    stop: Array
    skin: Array
    #: Opaque gel: it stops light that meets it before skin, and counts as skin behind it.
    backing: Array
    media: Array
    # Index of the stretch that begins or ends where the piece begins; -1 at the origin.
    span: Indices
    enters: Array


class Stack:
    """Optical model of a sensor, built from a light document."""

    def __init__(self, light: dict[str, Any]):
        self.light, self.forest = light, Forest()
        self.names: list[str] = light["seen_by_names"]
        self.items: list[Item] = []
        for body in light["bodies"]:
            part = _part(body)
            for placed in body["placements"]:
                if placed["is_cameras_own"]:
                    continue
                node = self.forest.plant(body["solid"], placed["sensor_from_body"])
                name = FIRST_BODY + self.names[FIRST_BODY:].index(body["name"])
                index = body["refractive_index"] if part == "medium" else AIR
                self.items.append(Item(node, part, index, body["is_skin"], name))
        media = {(i.index, i.is_skin) for i in self.items if i.part == "medium"}
        self.media = sorted(media)
        self.surface = light.get("surface") and self.forest.plant(light["surface"]["solid"])

    def pixels(self, column: Array, row: Array) -> Rays:
        """Returns the rays of pixels; (0, 0) is the first pixel's centre."""
        camera = self.light["camera"]
        pose = camera["sensor_from_camera"]
        d = directions(camera, column, row) @ np.array(pose["rotation"]).T
        return Rays(np.broadcast_to(np.array(pose["translation_mm"]), d.shape).copy(), d)

    def exit(self, rays: Rays) -> Array:
        """Returns the distance at which rays leave through the sensing surface; NaN if they do not."""
        result = np.full(len(rays), np.nan)
        if not self.surface:
            return result
        spans = self.surface.spans(rays)
        ahead = np.flatnonzero(spans.high > START_MM)
        # Sort descending: of several exits of a ray the nearest is written last and stays.
        ahead = ahead[np.argsort(-spans.high[ahead], kind="stable")]
        result[spans.ray[ahead]] = spans.high[ahead]
        z = rays.o[:, 2] + result * rays.d[:, 2]
        return np.where(z >= self.light["surface"]["foot_z_mm"], result, np.nan)

    def follow(self, rays: Rays, clear_only: bool = False) -> Paths:
        """Traces rays to their ends. With `clear_only`, opaque bodies do not stop them."""
        n = len(rays)
        seen, point = np.zeros(n, int), np.full((n, 3), np.nan)
        bends, corners = np.zeros(n, int), [rays.o.copy()]
        index = np.full(n, np.nan)
        alive, here = np.arange(n), Rays(rays.o.copy(), rays.d.copy())
        for _ in range(MOST_BENDS):
            if len(alive) == 0:
                break
            name, at, to_index, normal = self._piece(here, index[alive], clear_only)
            ended = name >= 0
            seen[alive[ended]] = name[ended]
            with np.errstate(invalid="ignore"):
                meets = here.o + at[:, None] * here.d
            point[alive[ended]] = meets[ended]
            going = np.flatnonzero(~ended)
            first = np.isnan(index[alive[going]])
            before = np.where(first, AIR, index[alive[going]])
            d, mirrored = refract(here.d[going], normal[going], before / to_index[going])
            lost = going[mirrored]
            seen[alive[lost]], point[alive[lost]] = len(self.names) - 1, meets[lost]
            going, d = going[~mirrored], d[~mirrored]
            index[alive[going]] = to_index[going]
            alive, here = alive[going], Rays(meets[going], d)
            bends[alive] += 1
            corner = np.full((n, 3), np.nan)
            corner[alive] = here.o
            corners.append(corner)
        return Paths(seen, point, bends, corners)

    def _walk(self, rays: Rays, clear_only: bool) -> tuple[_Walk, Spans, Indices]:
        """Cuts rays into pieces; also returns all stretches and the item of each."""
        found: list[Spans] = [Spans.none()]
        owner: list[Indices] = [np.zeros(0, int)]
        for number, item in enumerate(self.items):
            if clear_only and item.part == "stop" and not item.is_skin:
                continue
            spans = item.node.spans(rays)
            if len(spans):
                found.append(spans)
                owner.append(np.full(len(spans), number))
        joined = Spans(*(np.concatenate([getattr(s, k) for s in found])
                         for k in ("ray", "low", "high", "face_low", "face_high")))
        item = np.concatenate(owner)
        ahead = joined.high > START_MM
        joined = Spans(joined.ray[ahead], joined.low[ahead], joined.high[ahead],
                       joined.face_low[ahead], joined.face_high[ahead])
        item = item[ahead]
        n, m = len(rays), len(joined)
        ray = np.concatenate([np.arange(n), joined.ray, joined.ray])
        t = np.concatenate([np.zeros(n), np.maximum(joined.low, 0.0), joined.high])
        sign = np.concatenate([np.zeros(n, int), np.ones(m, int), -np.ones(m, int)])
        span = np.concatenate([np.full(n, -1), np.arange(m), np.arange(m)])
        order = np.lexsort((np.abs(sign), t, ray))
        ray, t, sign, span = ray[order], t[order], sign[order], span[order]
        part = np.array([-1] + [self._category(i) for i in self.items])[
            np.where(span < 0, 0, item[span] + 1) if m else np.zeros(len(span), int)]

        def count(category: int) -> Array:
            return np.cumsum(np.where(part == category, sign, 0))

        after = np.append(t[1:], np.inf)
        after[np.append(ray[1:] != ray[:-1], True)] = np.inf
        media = np.stack([count(3 + k) for k in range(len(self.media))] or [np.zeros(len(t))])
        with np.errstate(invalid="ignore"):
            length = np.where(np.isinf(t), 0.0, after - t)
        walk = _Walk(ray, t, span < 0, length, count(0) > 0, count(1) > 0, count(2) > 0,
                     media > 0, span, sign > 0)
        return walk, joined, item

    def _category(self, item: Item) -> int:
        if item.part == "medium":
            return 3 + self.media.index((item.index, item.is_skin))
        if item.part == "stop":
            return 2 if item.is_skin else 0
        return 1

    def _piece(self, rays: Rays, index: Array, clear_only: bool
               ) -> tuple[Indices, Array, Array, Array]:
        """Finds the end of each straight piece.

        Returns an index into `seen_by_names`, or -1 where the ray is refracted; the distance; the refractive index
        behind; and the face's normal.
        """
        n = len(rays)
        walk, spans, item = self._walk(rays, clear_only)
        indices = np.array([m[0] for m in self.media] or [AIR])
        here = np.where(walk.media.any(0), indices[walk.media.argmax(0)], AIR)
        stops = walk.stop | walk.backing
        solid, real = stops | walk.skin, walk.length > TOUCH_MM
        # A ray starts in the medium of its first real piece.
        first = np.flatnonzero(real & ~solid)
        first = first[np.unique(walk.ray[first], return_index=True)[1]]
        start = index.copy()
        unknown = np.isnan(start[walk.ray[first]])
        # A piece behind something opaque does not count, but then nothing is refracted before it either.
        start[walk.ray[first[unknown]]] = here[first[unknown]]
        event = np.flatnonzero(real & (solid | (here != start[walk.ray])))
        event = event[np.unique(walk.ray[event], return_index=True)[1]]
        name, at = np.zeros(n, int), np.full(n, np.inf)
        to_index, normal = np.full(n, AIR), np.full((n, 3), np.nan)
        ray = walk.ray[event]
        at[ray], to_index[ray], name[ray] = walk.t[event], here[event], -1
        exit_mm = self.exit(rays)
        stopped = event[stops[event]]
        name[walk.ray[stopped]] = self._named(walk, item, stopped, "stop")
        skinned = event[walk.skin[event] & ~stops[event]]
        self._through_skin(walk, item, skinned, exit_mm, name, at)
        bent = event[~solid[event]]
        ray = walk.ray[bent]
        with np.errstate(invalid="ignore"):
            seen = (here[bent] == AIR) & (start[ray] != AIR) & ~walk.media[:, bent].any(0)
            seen &= np.abs(exit_mm[ray] - walk.t[bent]) <= TOUCH_MM
        name[ray[seen]] = SURFACE
        index[:] = start
        bent = bent[~seen]
        ray = walk.ray[bent]
        points = rays.o[ray] + walk.t[bent][:, None] * rays.d[ray]
        normal[ray] = self.forest.normals(points, self._faces(walk, spans, item, bent))
        return name, at, to_index, normal

    def _named(self, walk: _Walk, item: Indices, events: Indices, part: str) -> Indices:
        """Returns the name of the item of one part that a ray entered last before each event."""
        is_part = np.array([i.part == part for i in self.items] + [False])
        entered = walk.enters & is_part[np.where(walk.span < 0, -1, item[walk.span])]
        last = np.maximum.accumulate(np.where(entered, np.arange(len(entered)), -1))[events]
        return np.array([i.name for i in self.items])[item[walk.span[last]]]

    def _through_skin(self, walk: _Walk, item: Indices, events: Indices, exit_mm: Array,
                      name: Indices, at: Array) -> None:
        """Ends rays that meet skin: at the sensing surface if there is only skin up to it, else at the skin."""
        is_skin = np.array([m[1] for m in self.media] or [False])
        skin = walk.skin | walk.backing | (walk.media & is_skin[:, None]).any(0)
        gap = (walk.length > TOUCH_MM) & (walk.stop | ~skin)
        begin = np.full(len(at), np.inf)
        begin[walk.ray[events]] = walk.t[events]
        with np.errstate(invalid="ignore"):
            between = walk.t < exit_mm[walk.ray] - TOUCH_MM
            gap &= (walk.t >= begin[walk.ray]) & between
        has_gap = np.zeros(len(at), bool)
        has_gap[walk.ray[gap]] = True
        ray = walk.ray[events]
        free = ~has_gap[ray] & ~np.isnan(exit_mm[ray])
        name[ray] = np.where(free, SURFACE, self._named(walk, item, events, "skin"))
        at[ray] = np.where(free, exit_mm[ray], at[ray])

    def _faces(self, walk: _Walk, spans: Spans, item: Indices, events: Indices) -> Indices:
        """Returns the face at which a piece begins: of a medium that is entered there, else of the one that is left."""
        result = np.full(len(events), -1)
        of = walk.ray[events]
        for sign in (False, True):
            # Crossings within the touch distance before the event count too; the last one is written last and stays.
            for back in (3, 2, 1, 0):
                k = events - back
                near = (k >= 0) & (walk.ray[k] == of) & (walk.span[k] >= 0)
                near &= (walk.t[events] - walk.t[k] <= TOUCH_MM) & (walk.enters[k] == sign)
                k = k[near]
                face = spans.face_low if sign else spans.face_high
                result[near] = face[walk.span[k]]
        assert (result >= 0).all()
        return result


def _part(body: dict[str, Any]) -> str:
    """Derives a body's role for light (medium, skin or stop) from its properties; checks that the document agrees."""
    shows = body["is_looked_at"]
    if body["clarity"] == "clear":
        part, is_skin = "medium", shows
    elif body.get("is_marker", False):
        part, is_skin = "stop", True
    else:
        part = "skin" if shows else "stop"
        is_skin = shows or body["kind"] == "layer"
    if (part, is_skin) != (body["part"], body["is_skin"]):
        raise ValueError(f"{body['name']}: said to be {body['part']}, its properties make it {part}")
    return part


def refract(d: Array, normal: Array, ratio: Array) -> tuple[Array, Array]:
    """Refracts directions by Snell's law; `ratio` is the index before over the one behind.

    Returns the directions, and a mask of total reflection. The tangential component grows by the ratio.
    """
    cosine = (d * normal).sum(-1)
    normal = np.where(cosine < 0.0, -1.0, 1.0)[:, None] * normal
    sine = d - np.abs(cosine)[:, None] * normal
    sine = ratio[:, None] * sine
    rest = 1.0 - (sine * sine).sum(-1)
    with np.errstate(invalid="ignore"):
        out = sine + np.sqrt(rest)[:, None] * normal
    return out / np.linalg.norm(out, axis=-1, keepdims=True), rest <= 0.0
