"""Reader and validator of tree documents (`fabkit-tree` version 1) and samples documents.

docs/tree.md describes the format for people and docs/tree.schema.json for machines. The check here
is stricter than a schema can be: rotations must be rotations, paths must close, arcs must end on
their circles.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

TREE_FORMAT, TREE_VERSION = "fabkit-tree", 1
SAMPLES_FORMAT, SAMPLES_VERSION = "fabkit-samples", 1

# Tolerance of orthonormal rows. Rotations are written with all digits of a double; this leaves room for
# products of many.
RIGID = 1e-9
# Tolerance of the ends of paths and arcs, mm, relative to the size of the numbers involved.
CLOSED = 1e-9
# Deepest accepted tree: deeper than any design's, but below Python's own recursion limit.
MAX_DEPTH = 200
# Number of problems in an error message; the rest is counted.
MAX_PROBLEMS = 10

Node = dict[str, Any]


class DocumentError(Exception):
    """A document is unusable; the message lists its problems."""

    def __init__(self, name: str, problems: list[str]):
        shown = problems[:MAX_PROBLEMS]
        if len(problems) > len(shown):
            shown.append(f"and {len(problems) - len(shown)} more problems")
        super().__init__(f"{name}: " + "; ".join(shown))


def read(path: Path) -> dict[str, Any]:
    """Reads and checks a tree document.

    Raises DocumentError if it is invalid, with the place of each problem as a JSON path.
    """
    document = _load(path, TREE_FORMAT, TREE_VERSION)
    problems: list[str] = []
    for key in ("name", "sensor", "kind"):
        if not isinstance(document.get(key), str):
            problems.append(f"${'.' + key} is missing or no text")
    for i, landmark in enumerate(_list(document, "landmarks", problems)):
        _vector(landmark, "point_mm", 3, f"$.landmarks[{i}]", problems)
        _vector(landmark, "axis", 3, f"$.landmarks[{i}]", problems)
    for i, placement in enumerate(_list(document, "placements", problems)):
        _pose(placement.get("assembly_from_body"), f"$.placements[{i}]", problems)
    if "solid" in document:
        _node(document["solid"], "$.solid", 0, problems)
    else:
        problems.append("$.solid is missing")
    if problems:
        raise DocumentError(path.name, problems)
    return document


def read_samples(path: Path) -> dict[str, Any]:
    """Reads a samples document: fabkit's properties of the exact solid (see docs/tree.md)."""
    document = _load(path, SAMPLES_FORMAT, SAMPLES_VERSION)
    missing = {"name", "figures", "lines", "points"} - document.keys()
    if missing:
        raise DocumentError(path.name, [f"$.{key} is missing" for key in sorted(missing)])
    return document


def _load(path: Path, wanted: str, version: int) -> dict[str, Any]:
    """Reads a JSON document and checks its format and version."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DocumentError(path.name, [f"cannot be read: {error.strerror}"]) from error
    except UnicodeDecodeError as error:
        raise DocumentError(path.name, [f"not UTF-8 text (byte {error.start})"]) from error
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise DocumentError(path.name, [f"not JSON, or cut short: {error.msg} ({where})"]) from error
    except RecursionError as error:
        raise DocumentError(path.name, ["nested too deeply"]) from error
    if not isinstance(document, dict) or document.get("format") != wanted:
        raise DocumentError(path.name, [f"not a {wanted} document"])
    if document.get("version") != version:
        found = document.get("version")
        raise DocumentError(path.name, [f"{wanted} version {found!r}; this verifier reads {version}"])
    return document


def _list(document: dict, key: str, problems: list[str]) -> list[dict]:
    entries = document.get(key)
    if isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries):
        return entries
    problems.append(f"$.{key} is missing or no list of objects")
    return []


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _vector(holder: dict, key: str, length: int, at: str, problems: list[str]) -> bool:
    value = holder.get(key)
    fine = isinstance(value, list) and len(value) == length and all(map(_is_number, value))
    if not fine:
        problems.append(f"{at}.{key} must be {length} finite numbers")
    return fine


def _number(holder: dict, key: str, at: str, problems: list[str], least: float = 0.0) -> None:
    """Checks that a number is above 0, or at least `least` if that is given."""
    value = holder.get(key)
    allowed = _is_number(value) and (value > 0.0 if least == 0.0 else value >= least)
    if not allowed:
        problems.append(f"{at}.{key} is {value!r}; it must be a finite number in its range")


def _pose(pose: Any, at: str, problems: list[str]) -> None:
    if not isinstance(pose, dict) or set(pose) != {"rotation", "translation_mm"}:
        problems.append(f"{at}: a pose has `rotation` and `translation_mm`")
        return
    if not _vector(pose, "translation_mm", 3, at, problems):
        return
    rows = pose["rotation"]
    square = isinstance(rows, list) and len(rows) == 3
    if not square or not all(_vector({"rotation": r}, "rotation", 3, at, problems) for r in rows):
        problems.append(f"{at}.rotation must be three rows of three numbers")
        return
    for i in range(3):
        for j in range(3):
            product = sum(rows[i][k] * rows[j][k] for k in range(3))
            if abs(product - (i == j)) > RIGID:
                problems.append(f"{at}.rotation is no rotation: its rows are not orthonormal")
                return
    if _determinant(rows) < 0.0:
        problems.append(f"{at}.rotation mirrors")


def _determinant(m: list[list[float]]) -> float:
    return (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )


def _sphere(of: dict, at: str, problems: list[str]) -> None:
    _number(of, "radius_mm", at, problems)


def _ellipsoid(of: dict, at: str, problems: list[str]) -> None:
    if _vector(of, "semi_axes_mm", 3, at, problems) and min(of["semi_axes_mm"]) <= 0.0:
        problems.append(f"{at}.semi_axes_mm must be above 0")


def _cylinder(of: dict, at: str, problems: list[str]) -> None:
    _number(of, "radius_mm", at, problems)
    _number(of, "height_mm", at, problems)


def _cone(of: dict, at: str, problems: list[str]) -> None:
    radii = [of.get("bottom_radius_mm"), of.get("top_radius_mm")]
    if not all(map(_is_number, radii)) or min(radii) < 0.0 or max(radii) <= 0.0:
        problems.append(f"{at}: radii {radii}; one of them must be above 0, none below")
    _number(of, "height_mm", at, problems)


def _cuboid(of: dict, at: str, problems: list[str]) -> None:
    if _vector(of, "size_mm", 3, at, problems) and min(of["size_mm"]) <= 0.0:
        problems.append(f"{at}.size_mm must be above 0")


def _torus(of: dict, at: str, problems: list[str]) -> None:
    _number(of, "ring_radius_mm", at, problems)
    _number(of, "tube_radius_mm", at, problems)


def _half_space(of: dict, at: str, problems: list[str]) -> None:
    del of, at, problems  # It has no measures.


def _extrusion(of: dict, at: str, problems: list[str]) -> None:
    _number(of, "height_mm", at, problems)
    _profile(of.get("profile"), f"{at}.profile", ("line", "arc"), problems)


def _revolution(of: dict, at: str, problems: list[str]) -> None:
    _profile(of.get("profile"), f"{at}.profile", ("line", "arc", "elliptic-arc"), problems)


def _ellipsoid_offset(of: dict, at: str, problems: list[str]) -> None:
    _number(of, "equatorial_mm", at, problems)
    _number(of, "polar_mm", at, problems)
    _number(of, "offset_mm", at, problems, least=-math.inf)


# Fields of each primitive, and the function that checks them.
PRIMITIVES: dict[str, tuple[set[str], Callable[[dict, str, list[str]], None]]] = {
    "sphere": ({"radius_mm"}, _sphere),
    "ellipsoid": ({"semi_axes_mm"}, _ellipsoid),
    "cylinder": ({"radius_mm", "height_mm"}, _cylinder),
    "cone": ({"bottom_radius_mm", "top_radius_mm", "height_mm"}, _cone),
    "cuboid": ({"size_mm"}, _cuboid),
    "torus": ({"ring_radius_mm", "tube_radius_mm"}, _torus),
    "half-space": (set(), _half_space),
    "extrusion": ({"profile", "height_mm"}, _extrusion),
    "revolution": ({"profile"}, _revolution),
    "ellipsoid-offset": ({"equatorial_mm", "polar_mm", "offset_mm"}, _ellipsoid_offset),
}


def _profile(profile: Any, at: str, kinds: tuple[str, ...], problems: list[str]) -> None:
    if not isinstance(profile, dict) or not {"outer"} <= set(profile) <= {"outer", "holes"}:
        problems.append(f"{at}: a profile has `outer` and may have `holes`")
        return
    _path(profile["outer"], f"{at}.outer", kinds, problems)
    for i, hole in enumerate(profile.get("holes", [])):
        _path(hole, f"{at}.holes[{i}]", kinds, problems)


def _path(path: Any, at: str, kinds: tuple[str, ...], problems: list[str]) -> None:
    if not isinstance(path, dict) or set(path) != {"start", "segments"} or not path["segments"]:
        problems.append(f"{at}: a path has `start` and `segments`")
        return
    if not _vector(path, "start", 2, at, problems):
        return
    here = path["start"]
    for i, segment in enumerate(path["segments"]):
        where = f"{at}.segments[{i}]"
        if not isinstance(segment, dict) or len(segment) != 1 or next(iter(segment)) not in kinds:
            problems.append(f"{where}: a segment has one key, one of {', '.join(kinds)}")
            return
        ((kind, how),) = segment.items()
        if not _vector(how, "to", 2, where, problems):
            return
        if kind != "line" and not _on_curve(how, here, where, problems):
            return
        here = how["to"]
    scale = 1.0 + max(map(abs, here))
    if math.dist(here, path["start"]) > CLOSED * scale:
        problems.append(f"{at}: the path does not end where it begins")


def _on_curve(how: dict, start: list[float], at: str, problems: list[str]) -> bool:
    if not isinstance(how.get("ccw"), bool) or not _vector(how, "centre", 2, at, problems):
        problems.append(f"{at}: an arc has `to`, `centre` and `ccw`")
        return False
    if "semi_axes_mm" not in how:
        radii = [math.dist(end, how["centre"]) for end in (start, how["to"])]
        if abs(radii[0] - radii[1]) > CLOSED * (1.0 + radii[0]):
            problems.append(f"{at}: the arc ends {radii[1]} mm from its centre, not {radii[0]}")
            return False
    elif not _vector(how, "semi_axes_mm", 2, at, problems):
        return False
    return True


def _node(node: Any, at: str, depth: int, problems: list[str]) -> None:
    # A damaged document may have thousands of problems.
    if len(problems) > 10 * MAX_PROBLEMS:
        return
    if depth > MAX_DEPTH:
        problems.append(f"{at}: more than {MAX_DEPTH} levels")
        return
    if not isinstance(node, dict) or len(node) != 1:
        problems.append(f"{at}: a node is an object with one key, its kind")
        return
    ((kind, of),) = node.items()
    here = f"{at}.{kind}"
    if kind in PRIMITIVES:
        fields, check = PRIMITIVES[kind]
        if not isinstance(of, dict) or set(of) != fields:
            problems.append(f"{here} must have {sorted(fields)} and nothing else")
        else:
            check(of, here, problems)
    elif kind in ("union", "intersection"):
        if not isinstance(of, list) or not of:
            problems.append(f"{here} must be a list with something in it")
            return
        for i, child in enumerate(of):
            _node(child, f"{here}[{i}]", depth + 1, problems)
    elif kind == "difference" and isinstance(of, dict) and set(of) == {"of", "minus"}:
        _node(of["of"], f"{here}.of", depth + 1, problems)
        for i, tool in enumerate(of["minus"]):
            _node(tool, f"{here}.minus[{i}]", depth + 1, problems)
    elif kind == "placed" and isinstance(of, dict) and set(of) == {"pose", "of"}:
        _pose(of["pose"], f"{here}.pose", problems)
        _node(of["of"], f"{here}.of", depth + 1, problems)
    elif kind == "feature" and isinstance(of, dict) and set(of) == {"name", "of"}:
        _node(of["of"], f"{here}.of", depth + 1, problems)
    elif kind in ("difference", "placed", "feature"):
        problems.append(f"{here} has other fields than it should")
    else:
        problems.append(f"{at}: unknown kind `{kind}`")
