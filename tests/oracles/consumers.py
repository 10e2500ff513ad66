"""Checks exported STL and 3MF files with admesh and PrusaSlicer.

    python consumers.py admesh|prusa-slicer PATH_TO_FABKIT [EVERY]
    python consumers.py settings PATH_TO_FABKIT [SENSOR[/PART]...]

Both programs exit with 0 whatever they find, so their output is parsed: admesh must repair nothing; the slicer must
call each mesh manifold, find the volume that the manifest states, and slice it into layers that reach its height.
With EVERY, only every EVERY-th part is checked.

`settings` checks that 3MF files of filament parts carry their print settings. It slices each with contrary options,
and the same part as STL with the settings of the 3MF as options: layers, lines of each type and filament must be
equal. By default it checks all parts of all sensors, which takes an hour.
"""

import json
import re
import subprocess
import sys
import tempfile
import zipfile
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

# Counters of admesh's repairs; each must be 0.
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
# Processes that use an ordinary slicer; jetted parts have their own.
PRINTED = ("fdm", "sla")


def output(*command: str) -> str:
    # admesh 0.98 prints some bytes of memory after a file's header of 80 bytes: replace invalid characters.
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
    # The slicer sums in single precision.
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


# Options of a user's own profile; the object's settings in the file must override them.
AGAINST = ("--layer-height=0.3", "--perimeters=7", "--fill-density=3%", "--support-material",
           "--brim-width=3", "--top-solid-layers=1", "--bottom-solid-layers=1")
# OrcaSlicer's names for settings that PrusaSlicer names differently.
ORCA = {"perimeters": "wall_loops", "top_solid_layers": "top_shell_layers",
        "bottom_solid_layers": "bottom_shell_layers", "fill_density": "sparse_infill_density",
        "support_material": "enable_support"}


def settings_of(path: Path) -> dict:
    """Reads the settings of a 3MF file with one part, by PrusaSlicer's names; checks that OrcaSlicer's are the same."""
    with zipfile.ZipFile(path) as archive:
        model = ElementTree.fromstring(archive.read("3D/3dmodel.model"))
        prusa = ElementTree.fromstring(archive.read("Metadata/Slic3r_PE_model.config"))
        orca = ElementTree.fromstring(archive.read("Metadata/model_settings.config"))
        assert archive.read("Metadata/thumbnail.png").startswith(b"\x89PNG\r\n"), path.name
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    (built,) = (item.get("objectid") for item in model.iter(f"{core}item"))
    (about,) = (m.text for m in model.iter(f"{core}metadata") if m.get("name") == "Description")
    assert about.startswith(f"{path.stem}: layers "), about
    (object_,), (twin,) = prusa.findall("object"), orca.findall("object")
    assert object_.get("id") == twin.get("id") == built, path.name
    said = {m.get("key"): m.get("value") for m in object_.findall("metadata")}
    also = {m.get("key"): m.get("value") for m in twin.findall("metadata")}
    assert said.pop("name") == also.pop("name") == path.stem
    assert also.pop("brim_type") == ("outer_only" if float(said["brim_width"]) else "no_brim")
    assert {ORCA.get(key, key): value for key, value in said.items()} == also, path.name
    (volume,) = object_.findall("volume")
    triangles = sum(1 for _ in model.iter(f"{core}triangle"))
    assert (volume.get("firstid"), volume.get("lastid")) == ("0", str(triangles - 1)), path.name
    return said


def sliced(path: Path, *options: str) -> tuple:
    """Slices a file; returns layers, number of lines by type, filament in mm, and the settings that were used."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sliced.gcode"
        said = output("prusa-slicer", "--datadir", folder, "--export-gcode", *options, "-o", str(file),
                      str(path))
        assert file.is_file(), f"{path.name} cannot be sliced\n{said}"
        text = file.read_text()
    layers = re.findall(r"^;Z:([\d.]+)", text, re.MULTILINE)
    types = Counter(re.findall(r"^;TYPE:(.+)$", text, re.MULTILINE))
    (filament,) = re.findall(r"^; filament used \[mm\] = ([\d.]+)", text, re.MULTILINE)
    return layers, types, float(filament), dict(re.findall(r"^; (\w+) = (.*)$", text, re.MULTILINE))


def check_settings(binary: str, design: str) -> int:
    with tempfile.TemporaryDirectory() as folder:
        output(binary, "export", design, "--quiet", "--force", "--format=3mf,stl", "-o", folder)
        manifest = json.loads((Path(folder) / "manifest.json").read_text())
        count = 0
        for part in manifest["parts"]:
            path = Path(folder) / f"{part['name']}.3mf"
            if part["process"] != "fdm":
                if path.is_file():
                    with zipfile.ZipFile(path) as archive:
                        assert not any(name.endswith(".config") for name in archive.namelist()), path.name
                continue
            said = settings_of(path)
            layers, types, filament, _ = sliced(path, *AGAINST)
            words = (f"--{key.replace('_', '-')}={value}" for key, value in said.items()
                     if key != "support_material")
            support = ["--support-material"] if said["support_material"] == "1" else []
            wanted = sliced(path.with_suffix(".stl"), *words, *support)
            used = {key: wanted[3][key] for key in said}
            assert used == said, f"{path.name}: {used} in place of {said}"
            assert layers == wanted[0], f"{path.name}: layers {layers[:3]}, not {wanted[0][:3]}"
            # Positions on the bed differ by micrometres, so short gap fills may differ.
            differ = sum((types - wanted[1]).values()) + sum((wanted[1] - types).values())
            assert differ <= max(6, 0.01 * sum(types.values())), f"{path.name}: {types} in place of {wanted[1]}"
            assert abs(filament / wanted[2] - 1.0) < 0.002, f"{path.name}: {filament} of {wanted[2]} mm"
            count += 1
    return count


def check_all_settings(binary: str, designs: list[str]) -> None:
    listed = [sensor["name"] for sensor in json.loads(output(binary, "--json", "list"))["sensors"]]
    parts = sum(check_settings(binary, design) for design in designs or listed)
    assert parts > 0, "there was nothing to slice"
    print(f"prusa-slicer takes the settings of all {parts} parts of filament")


CHECKS = {"admesh": check_with_admesh, "prusa-slicer": check_with_slicer}


def main(consumer: str, binary: str, every: int = 1) -> None:
    listed = json.loads(output(binary, "--json", "list"))
    seen = files = 0
    for sensor in listed["sensors"]:
        with tempfile.TemporaryDirectory() as folder:
            output(binary, "export", sensor["name"], "--quiet", "--format=stl", "-o", folder)
            manifest = json.loads((Path(folder) / "manifest.json").read_text())
            for part in manifest["parts"]:
                # admesh reads parts of all processes.
                if consumer == "admesh" or part["process"] in PRINTED:
                    seen += 1
                    if seen % every == 0:
                        CHECKS[consumer](Path(folder) / f"{part['name']}.stl", part)
                        files += 1
    assert files > 0, "there was nothing to check"
    print(f"{consumer} accepts all {files} files")


if __name__ == "__main__":
    if sys.argv[1] == "settings":
        check_all_settings(sys.argv[2], sys.argv[3:])
    else:
        main(*sys.argv[1:3], *map(int, sys.argv[3:4]))
