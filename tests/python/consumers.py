"""Lets the programs that people print with read what `fabkit export` writes.

    python consumers.py admesh|prusa-slicer PATH_TO_FABKIT

Both exit with 0 whatever they find, so that their text is read: admesh must repair nothing, the
slicer must call each mesh manifold, see the volume that the manifest states, and slice it into
layers that reach its height.
"""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# What admesh would have repaired; every counter must be 0.
REPAIRS = (
    "Total disconnected facets",
    "Degenerate facets",
    "Edges fixed",
    "Facets removed",
    "Facets added",
    "Facets reversed",
    "Backwards edges",
    "Normals fixed",
)
# What an ordinary slicer is for; jetted parts have their own.
PRINTED = ("fdm", "sla")


def output(*command: str) -> str:
    # admesh 0.98 prints a few bytes of memory behind a file's header of 80.
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    assert done.returncode == 0, f"{command}: exit {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout + done.stderr


def check_with_admesh(path: Path, part: dict) -> None:
    text = output("admesh", str(path))
    for repair in REPAIRS:
        found = re.search(rf"^{repair}\s*:\s*(\d+)", text, re.MULTILINE)
        assert found, f"{path.name}: admesh does not say `{repair}`\n{text}"
        assert found.group(1) == "0", f"{path.name}: {repair}: {found.group(1)}"
    (count,) = re.findall(r"^Number of facets\s*:\s*(\d+)", text, re.MULTILINE)
    assert int(count) == part["mesh"]["triangles"], f"{path.name}: {count} triangles"


def check_with_slicer(path: Path, part: dict) -> None:
    text = output("prusa-slicer", "--info", str(path))
    found = dict(re.findall(r"^(\w+) =\s+(\S+)$", text, re.MULTILINE))
    assert found["manifold"] == "yes", f"{path.name}: {text}"
    repairs = {k: v for k, v in found.items() if k.startswith(("facets_", "open_", "edges_"))}
    assert not any(v not in ("0", "no") for v in repairs.values()), f"{path.name}: {repairs}"
    assert int(found["number_of_facets"]) == part["mesh"]["triangles"], f"{path.name}: {found}"
    volume = part["mesh"]["volume_mm3"]
    # It sums in single precision.
    assert abs(float(found["volume"]) - volume) < 1e-4 * volume, f"{path.name}: {found['volume']}"

    height = part["bounds_in_file_mm"][1][2]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sliced.gcode"
        said = output("prusa-slicer", "--export-gcode", "--layer-height", "0.2",
                      "--first-layer-height", "0.2", "-o", str(file), str(path))
        assert file.is_file(), f"{path.name} cannot be sliced\n{said}"
        layers = [float(z) for z in re.findall(r"^;Z:([\d.]+)", file.read_text(), re.MULTILINE)]
    assert layers, f"{path.name}: no layers\n{said}"
    # The last layer's top is at most one layer below or above that of the part.
    assert abs(max(layers) - height) < 0.2, f"{path.name}: sliced to {max(layers)} of {height} mm"


CHECKS = {"admesh": check_with_admesh, "prusa-slicer": check_with_slicer}


def main(consumer: str, binary: str) -> None:
    listed = json.loads(output(binary, "--json", "list"))
    files = 0
    for sensor in listed["sensors"]:
        with tempfile.TemporaryDirectory() as folder:
            output(binary, "export", sensor["name"], "--quiet", "--format=stl", "-o", folder)
            manifest = json.loads((Path(folder) / "manifest.json").read_text())
            for part in manifest["parts"]:
                # admesh reads everything.
                if consumer == "admesh" or part["process"] in PRINTED:
                    CHECKS[consumer](Path(folder) / f"{part['name']}.stl", part)
                    files += 1
    assert files > 0, "there was nothing to check"
    print(f"{consumer} accepts all {files} files")


if __name__ == "__main__":
    main(*sys.argv[1:3])
