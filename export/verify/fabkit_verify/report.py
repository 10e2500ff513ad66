"""Report of a verification as one HTML file without dependencies.

Each disagreement with known points gets an image: three views of points on the exact surface, where the
sampled lines cross it, with the points of disagreement in red.
"""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import numpy

from . import document

# Side of a view, px.
VIEW_PX = 260
# Title, index of the axis to the right, index of the axis upwards.
VIEWS = (("from the front", 0, 2), ("from the right", 1, 2), ("from above", 0, 1))
# Largest number of points of the exact surface in an image.
MOST_POINTS = 1500

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 64em; padding: 0 1em; }
table { border-collapse: collapse; } th, td { padding: .2em .8em; text-align: left; }
tr:nth-child(even) { background: #f4f4f4; } td.agrees { color: #17652f; }
td.differs, td.failed { color: #fff; background: #b3261e; }
svg { border: 1px solid #ccc; margin: .3em; } .exact { fill: #999; } .off { fill: #b3261e; }
"""


def write(path: Path, verification: dict[str, Any], folder: Path) -> None:
    """Writes the report. Raises OSError if the file cannot be written."""
    results = verification["results"]
    wrong = [result for result in results if result["verdict"] != "agrees"]
    parts = list(dict.fromkeys(result["part"] for result in results))
    title = "Everything agrees" if not wrong else f"{len(wrong)} disagreements"
    sections = [_section(result, folder) for result in wrong]
    text = f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><title>{title}</title><style>{STYLE}</style>
<h1>{title}</h1>
<p>{len(parts)} bodies, rebuilt from their trees by {escape(", ".join(verification["kernels"]))}.
Each cell: largest relative difference in volume, largest distance between surfaces.</p>
{_table(parts, verification["kernels"], results)}
{"".join(sections)}
</html>
"""
    path.write_text(text, encoding="utf-8")


def _table(parts: list[str], kernels: list[str], results: list[dict]) -> str:
    cells = {(result["part"], result["kernel"]): result for result in results}
    head = "".join(f"<th>{escape(kernel)}</th>" for kernel in kernels)
    rows = []
    for part in parts:
        row = "".join(_cell(cells.get((part, kernel))) for kernel in kernels)
        rows.append(f"<tr><th>{escape(part)}</th>{row}</tr>")
    return f"<table><tr><th>part</th>{head}</tr>{''.join(rows)}</table>"


def _cell(result: dict | None) -> str:
    if result is None:
        return "<td></td>"
    words = result["verdict"]
    if result["volume"] is not None and result["distance_mm"] is not None:
        words += f" {result['volume']:.0e}, {1000 * result['distance_mm']:.3f} µm"
    return f'<td class="{result["verdict"]}">{words}</td>'


def _section(result: dict, folder: Path) -> str:
    heading = f"{result['part']} in {result['kernel']}"
    checks = [check for check in result["checks"] if not check["passed"]]
    rows = "".join(_row(check) for check in checks)
    table = f"<table><tr><th>what</th><th>value</th><th>limit</th><th></th></tr>{rows}</table>"
    places = [place for check in checks for place in check["places_mm"]]
    picture = _picture(folder / f"{result['part']}.samples.json", places) if places else ""
    reason = f"<p>{escape(result['reason'])}</p>"
    return f"<h2>{escape(heading)}</h2>{reason}{table if checks else ''}{picture}"


def _row(check: dict) -> str:
    value = "" if check["value"] is None else f"{check['value']:.4g}"
    unit = escape(check["unit"])
    limit = f"{check['limit']:.4g} {unit}"
    note = escape(check["note"])
    return f"<tr><td>{check['what']}</td><td>{value} {unit}</td><td>{limit}</td><td>{note}</td></tr>"


def _picture(samples: Path, places: list[list[float]]) -> str:
    exact = []
    for line in document.read_samples(samples)["lines"]:
        origin, direction = numpy.array(line["origin_mm"]), numpy.array(line["direction"])
        exact += [origin + t * direction for t in line["t_mm"]]
    surface, off = numpy.array(exact[:: len(exact) // MOST_POINTS + 1]), numpy.array(places)
    everything = numpy.vstack([surface, off])
    low, high = everything.min(0), everything.max(0)
    scale = VIEW_PX / (1.1 * float((high - low).max()))
    centre = 0.5 * (low + high)
    return "".join(_view(*view, surface, off, centre, scale) for view in VIEWS)


def _view(title, right, up, surface, off, centre, scale) -> str:
    def dots(points, name, radius):
        across = VIEW_PX / 2 + scale * (points[:, right] - centre[right])
        down = VIEW_PX / 2 - scale * (points[:, up] - centre[up])
        circles = (f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}"/>' for x, y in zip(across, down))
        return f'<g class="{name}">{"".join(circles)}</g>'

    label = f'<text x="6" y="16" font-size="12">{title}</text>'
    body = dots(surface, "exact", 1) + dots(off, "off", 3) + label
    size = f'width="{VIEW_PX}" height="{VIEW_PX}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{body}</svg>'
