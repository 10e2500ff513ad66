"""Checks the circuit boards of `fabkit export --format gerber` with gerbv and pygerber.

    python check_boards.py PATH_TO_FABKIT [DESIGN ...]

By default it checks every built-in sensor with a circuit board. gerbv must read all layers and drills together without
a message, and pygerber each layer. The layers are then parsed here again and compared with the board's description and
with the sensor: pads, their corners and tracks, the outline's extent, drills, and LEDs on the part's landmarks, all
within 0.01 mm. In pygerber's image of the copper, pads and vias must be at their described positions, too.
"""

from __future__ import annotations

import json
import logging
import math
import re
import shutil
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

WITHIN_MM = 0.01
SENSORS = ["rtac0", "uvdtact", "tactip", "9dtact"]
# Resolution of pygerber's images, dots per mm.
DPMM = 100


def run(*words: str) -> str:
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}: exit {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


class Layer:
    """Flashes, lines and arcs of a Gerber layer, mm."""

    def __init__(self, path: Path) -> None:
        text = path.read_text()
        assert "%FSLAX46Y46*%" in text and "%MOMM*%" in text, path
        macros = {
            name: [float(number) for number in body.split(",")]
            for name, body in re.findall(r"%AM(\w+)\*\n?([^*]*)\*%", text)
        }
        self.apertures: dict[str, object] = {}
        for number, shape in re.findall(r"%ADD(\d+)([^*]*)\*%", text):
            if shape.startswith("C,"):
                self.apertures[number] = float(shape[2:])
            else:
                values = macros[shape][3:-1]
                self.apertures[number] = list(zip(values[0:-2:2], values[1:-2:2]))
        self.flashes: list[tuple[object, tuple[float, float]]] = []
        self.lines: list[tuple[tuple[float, float], tuple[float, float], float]] = []
        self.extent: list[tuple[float, float]] = []
        aperture, at, way = None, (0.0, 0.0), "G01"
        for line in text.splitlines():
            if match := re.fullmatch(r"D(\d\d+)\*", line):
                aperture = self.apertures[match[1]]
            elif line in ("G01*", "G02*", "G03*"):
                way = line[:3]
            elif match := re.fullmatch(r"X(-?\d+)Y(-?\d+)(?:I(-?\d+)J(-?\d+))?D0(\d)\*", line):
                to = (int(match[1]) / 1e6, int(match[2]) / 1e6)
                if match[5] == "3":
                    self.flashes.append((aperture, to))
                elif match[5] == "1" and match[3] is None:
                    self.lines.append((at, to, aperture))
                    self.extent += [at, to]
                elif match[5] == "1":
                    self.extent += arc(at, to, (int(match[3]) / 1e6, int(match[4]) / 1e6), way == "G03")
                at = to


def arc(at, to, offset, ccw) -> list[tuple[float, float]]:
    """Returns points of an arc, a hundredth of a radian apart."""
    centre = (at[0] + offset[0], at[1] + offset[1])
    radius = math.hypot(*offset)
    assert abs(math.dist(to, centre) - radius) < 2e-6, "the end of an arc is on its circle"
    start, end = (math.atan2(p[1] - centre[1], p[0] - centre[0]) for p in (at, to))
    sweep = (end - start) % math.tau if ccw else -((start - end) % math.tau)
    count = max(2, int(abs(sweep) * 100))
    angles = [start + sweep * i / count for i in range(count + 1)]
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


def drills(path: Path) -> list[tuple[float, float, float]]:
    """Reads x, y and diameter of each drilled hole, mm."""
    if not path.exists():
        return []
    text = path.read_text()
    assert "METRIC" in text and text.startswith("M48\n") and text.rstrip().endswith("M30"), path
    tools = {number: float(size) for number, size in re.findall(r"^T(\d+)C([\d.]+)$", text, re.M)}
    hits, tool = [], None
    for line in text.split("%", 1)[1].splitlines():
        if match := re.fullmatch(r"T(\d+)", line):
            tool = tools[match[1]]
        elif match := re.fullmatch(r"X(-?[\d.]+)Y(-?[\d.]+)", line):
            hits.append((float(match[1]), float(match[2]), tool))
    return hits


def same(found, wanted, what: str) -> None:
    """Checks that two lists of points or numbers are equal within the tolerance, in any order."""
    found, wanted = sorted(found), sorted(wanted)
    assert len(found) == len(wanted), f"{what}: {len(found)}, not {len(wanted)}"
    left = list(wanted)
    for one in found:
        near = min(left, key=lambda other: max(abs(a - b) for a, b in zip(one, other)))
        apart = max(abs(a - b) for a, b in zip(one, near))
        assert apart <= WITHIN_MM, f"{what}: {one} is {apart} mm from {near}"
        left.remove(near)


def path_points(path: dict) -> list[tuple[float, float]]:
    points, at = [tuple(path["start"])], tuple(path["start"])
    for segment in path["segments"]:
        (kind, values), = segment.items()
        to = tuple(values["to"])
        if kind == "arc":
            offset = (values["centre"][0] - at[0], values["centre"][1] - at[1])
            points += arc(at, to, offset, values["ccw"])
        points.append(to)
        at = to
    return points


def box(points) -> tuple[float, float, float, float]:
    xs, ys = zip(*points)
    return min(xs), max(xs), min(ys), max(ys)


def check_text(folder: Path, board: dict) -> None:
    name = board["board"]
    for letter, side in (("F", "top"), ("B", "bottom")):
        copper = Layer(folder / f"{name}-{letter}_Cu.gbr")
        mask = Layer(folder / f"{name}-{letter}_Mask.gbr")
        pads = [pad for pad in board["pads"] if pad["side"] == side]
        vias = board["vias"]
        centres = [tuple(one["at_mm"]) for one in pads + vias]
        same([at for _, at in copper.flashes], centres, f"{side} pads and vias")
        for pad in pads:
            at = pad["at_mm"]
            found = [shape for shape, there in copper.flashes if math.dist(there, at) <= WITHIN_MM]
            assert len(found) == 1, f"{pad['part']}.{pad['pin']}: {len(found)} flashes"
            if isinstance(found[0], float):
                assert abs(found[0] - 2 * pad["radius_mm"]) <= WITHIN_MM, pad
            else:
                corners = [(at[0] + x, at[1] + y) for x, y in found[0]]
                same(corners, [tuple(corner) for corner in pad["corners_mm"]], "corners")
            assert any(math.dist(there, at) <= WITHIN_MM for _, there in mask.flashes), pad
        assert len(mask.flashes) == len(pads), "an opening for each pad and no other"
        tracks = [t for t in board["tracks"] if t["side"] == side]
        same(
            [(*a, *b, width) for a, b, width in copper.lines],
            [(*t["ends_mm"][0], *t["ends_mm"][1], t["width_mm"]) for t in tracks],
            f"{side} tracks",
        )
    edge = Layer(folder / f"{name}-Edge_Cuts.gbr")
    same([box(edge.extent)], [box(path_points(board["profile"]["outer"]))], "extent of the outline")
    same(
        drills(folder / f"{name}-PTH.drl"),
        [(*via["at_mm"], via["drill_mm"]) for via in board["vias"]],
        "plated holes",
    )
    bare = [(*hole["at_mm"], hole["diameter_mm"]) for hole in board["drills"]]
    same(drills(folder / f"{name}-NPTH.drl"), bare, "holes that are not plated")
    milled = len(board["profile"]["holes"]) - len(bare)
    text = (folder / f"{name}-Edge_Cuts.gbr").read_text()
    assert text.count("D02*") == 1 + milled, "outline and milled holes"


def check_job(folder: Path, board: dict) -> None:
    job = json.loads((folder / f"{board['board']}.gbrjob").read_text())
    listed = {entry["Path"] for entry in job["FilesAttributes"]}
    there = {path.name for path in folder.iterdir() if path.suffix in (".gbr", ".drl")}
    assert listed == there, (listed, there)
    for entry in job["FilesAttributes"]:
        text = (folder / entry["Path"]).read_text()
        assert f"TF.FileFunction,{entry['FileFunction']}" in text, entry
    low_x, high_x, low_y, high_y = box(path_points(board["profile"]["outer"]))
    size = job["GeneralSpecs"]["Size"]
    same([(size["X"], size["Y"])], [(high_x - low_x, high_y - low_y)], "size in the job file")


def check_lamps(tree: dict, board: dict) -> None:
    """Checks that LEDs, and the middles between their pads, are on the part's landmarks."""
    marks = [tuple(mark["point_mm"][:2]) for mark in tree["landmarks"] if "led" in mark["name"]]
    leds = [part for part in board["parts"] if part["designator"].startswith("D")]
    same([tuple(part["at_mm"]) for part in leds], marks, "LEDs")
    middles = []
    for part in leds:
        ends = [pad["at_mm"] for pad in board["pads"] if pad["part"] == part["designator"]]
        assert len(ends) == 2, part
        middles.append(tuple(sum(end[axis] for end in ends) / 2 for axis in range(2)))
    same(middles, marks, "middles between LEDs' pads")


def check_gerbv(folder: Path) -> None:
    files = [path for path in sorted(folder.iterdir()) if path.suffix in (".gbr", ".drl")]
    picture = str(folder / "gerbv.png")
    said = run("gerbv", "--export=png", f"--output={picture}", "--dpi=600", *map(str, files))
    words = [line for line in said.splitlines() if line.strip()]
    assert not words, f"{folder}: gerbv says {words[:5]}"
    assert Path(picture).stat().st_size > 1000


def check_pygerber(folder: Path, board: dict) -> None:
    import numpy
    from PIL import Image
    from pygerber.gerberx3.api.v2 import GerberFile

    for path in sorted(folder.glob("*.gbr")):
        parsed = GerberFile.from_file(path).parse()
        if path.name.endswith(("F_Cu.gbr", "B_Cu.gbr")):
            picture = folder / (path.stem + ".png")
            parsed.render_raster(str(picture), dpmm=DPMM)
            info = parsed.get_info()
            left, top = float(info.min_x_mm), float(info.max_y_mm)
            drawn = numpy.asarray(Image.open(picture).convert("RGB")).max(axis=2) > 0
            side = "top" if "F_Cu" in path.name else "bottom"
            for one in [pad for pad in board["pads"] if pad["side"] == side] + board["vias"]:
                x, y = one["at_mm"]
                column, row = round((x - left) * DPMM), round((top - y) * DPMM)
                assert drawn[row - 3 : row + 3, column - 3 : column + 3].all(), f"{path.name}: {one}"


def check(binary: str, sensor: str) -> None:
    with tempfile.TemporaryDirectory() as root:
        run(binary, "export", sensor, "--format", "gerber", "-o", f"{root}/boards", "-q")
        for folder in sorted(path for path in Path(root, "boards").iterdir() if path.is_dir()):
            board = json.loads((folder / f"{folder.name}.board.json").read_text())
            run(
                binary, "export", sensor, "--format", "tree", "--part", folder.name,
                "-o", f"{root}/tree", "-q", "--force",
            )
            tree = json.loads(Path(root, "tree", f"{folder.name}.tree.json").read_text())
            check_text(folder, board)
            check_job(folder, board)
            check_lamps(tree, board)
            if shutil.which("gerbv"):
                check_gerbv(folder)
            else:
                print("gerbv is not installed: skipped")
            check_pygerber(folder, board)
            print(
                f"{sensor}/{folder.name}: {len(board['pads'])} pads, {len(board['tracks'])} tracks, "
                f"{len(board['vias'])} vias as described"
            )


def main() -> None:
    binary, *sensors = sys.argv[1:]
    # Every warning of a reader is an error.
    warnings.simplefilter("error")
    # These concern the author of the parser that pygerber uses.
    warnings.simplefilter("ignore", DeprecationWarning)
    logging.basicConfig(level=logging.WARNING)
    for sensor in sensors or SENSORS:
        check(binary, sensor)


if __name__ == "__main__":
    main()
