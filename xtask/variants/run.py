"""Random variants of every sensor and fixture, exported and judged by trimesh.

Run by `cargo xtask variants N`; by hand:

    python run.py path/to/fabkit N SEED

A variant changes one to six parameters of a built-in sensor or of one of its fixtures, each inside
the limits that `fabkit show --json` states: small moves, large ones, limits themselves, round and
crooked values, and what a refusal recommends. It is exported at a random tolerance. fabkit may make
it (exit 0), refuse it (2), or say that it is too large (3); anything else is a fault. Of what it
makes, each STL file is read by trimesh: every edge twice and in opposite directions, wound outwards,
no triangle without area, and as many shells and holes as the manifest says.

The same N and SEED give the same variants. Each fault is printed as a command line to be pasted, with
no more settings than it takes.
"""

import json
import math
import multiprocessing
import os
import random
import re
import resource
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
import trimesh

from moves import moved

# Seconds of work, and seconds by the clock of a busy machine, after which a command is taken to hang.
HANG_CPU_S, HANG_S = 60, 900
# Times that a refused variant takes a refusal's advice.
REPAIRS = 3
ALLOWED_EXITS = {0: "made", 2: "refused", 3: "too large"}
TOLERANCE_MM = (0.01, 1.0)
# Share of variants of a sensor that are exported as layers and components instead of parts, and of
# all variants that are exported without compensation.
BODIES, NOMINAL = 0.15, 0.2
# Share of a fixture's variants that change the sensor it is made for.
FOREIGN = 0.25
# Share of the variants of indenters in which all of them are made.
SHAPES, ALL_SHAPES = "fixtures.indenters.shapes", 0.7
# `x.y is 1 mm; it must be at most 2 mm, because ...` names the parameter of which the advice speaks.
COMPLAINT = re.compile(r"^(\S+) is .*; it must be (at (?:most|least)) ([^,]+), because")


def fabkit(binary, *arguments):
    """Exit code, and the document on standard output or the text on standard error."""
    command = [binary, "--json", *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=HANG_S, preexec_fn=limit_cpu
        )
    except subprocess.TimeoutExpired:
        return "hang", f"no end after {HANG_S} s"
    try:
        return done.returncode, json.loads(done.stdout)
    except json.JSONDecodeError:
        return done.returncode, done.stderr


def limit_cpu():
    resource.setrlimit(resource.RLIMIT_CPU, (HANG_CPU_S, HANG_CPU_S))


def targets(binary):
    """What can be exported: (name, parameters, bodies other than parts)."""
    code, listed = fabkit(binary, "list")
    assert code == 0, listed
    found = []
    for sensor in listed["sensors"]:
        for name in [sensor["name"], *(f"{sensor['name']}/{f}" for f in sensor["fixtures"])]:
            code, shown = fabkit(binary, "show", name)
            assert code == 0, shown
            bodies = [body["name"] for body in shown["bodies"] if body["kind"] != "part"]
            found.append((name, shown["parameters"], bodies))
    return found


def weight(name):
    """How often a target is drawn: presets differ from their sensors in numbers alone, and boards and
    coupons are plain."""
    often = 1 if name.endswith(("/boards", "/coupon")) else 3
    return often / 3 if "-published-" in name else often


def variant(targets, seed, index):
    """Target, settings and further arguments of one variant."""
    rng = random.Random(f"{seed} {index}")
    (name, parameters, bodies), = rng.choices(targets, [weight(name) for name, *_ in targets])
    fixture = name.partition("/")[2]
    own = [p for p in parameters if p["path"].startswith("fixtures.")]
    foreign = [p for p in parameters if not p["path"].startswith("fixtures.")]
    # One parameter most of the time: what several at once bring to light is mostly refused.
    count = rng.choice((1, 1, 1, 2, 2, 3, 4, 6))
    settings = {}
    if fixture == "indenters" and rng.random() < ALL_SHAPES:
        # By default a sensor has two or three of twelve.
        limits = next(p["limits"] for p in own if p["path"] == SHAPES)
        settings[SHAPES] = f"[{limits.partition(', each ')[2]}]"
        count += 1
    while len(settings) < count:
        pool = own if own and rng.random() >= FOREIGN else foreign
        parameter = rng.choice(pool)
        value = moved(rng, parameter["limits"], parameter["written"])
        if value is not None:
            settings[parameter["path"]] = value
    low, high = (math.log10(limit) for limit in TOLERANCE_MM)
    # Fine ones are rarer: they take longer.
    tolerance = 10 ** rng.triangular(low, high, high)
    arguments = ["--format", "stl", "--tolerance", f"{tolerance:.3g}mm"]
    if rng.random() < NOMINAL:
        arguments.append("--nominal")
    if fixture == "semi-domes":
        count = int(settings.get("fixtures.semi_domes.count", 100))
        halves = [f"semi-dome-{rng.randrange(count):03}" for _ in range(2)]
        arguments += [word for half in ["holder", *halves] for word in ("--part", half)]
    elif not fixture and bodies and rng.random() < BODIES:
        arguments += [word for body in set(rng.choices(bodies, k=3)) for word in ("--part", body)]
    return name, settings, sorted_parts(arguments)


def sorted_parts(arguments):
    """Parts in one order whatever the hashes of their names are."""
    words = [i for i, word in enumerate(arguments) if word == "--part"]
    names = sorted({arguments[i + 1] for i in words})
    rest = arguments[: words[0]] if words else arguments
    return rest + [word for name in names for word in ("--part", name)]


def export(binary, folder, name, settings, arguments):
    sets = [word for path, value in settings.items() for word in ("--set", f"{path}={value}")]
    shutil.rmtree(folder, ignore_errors=True)
    return fabkit(binary, "export", name, *sets, *arguments, "--threads", "1", "-o", str(folder))


def command(name, settings, arguments):
    sets = [word for path, value in settings.items() for word in ("--set", f"{path}={value}")]
    return shlex.join(["fabkit", "export", name, *sets, *arguments, "-o", "/tmp/variant"])


def advice(document, settings):
    """What a refusal recommends: the values, and for each path what was said of it."""
    better, said = {}, {}
    for problem in document.get("problems", []) if isinstance(document, dict) else []:
        found = COMPLAINT.match(problem["message"])
        if found:
            better[found[1]], said[found[1]] = found[3], found[2]
    return better, said


def faults_of_mesh(path, stated):
    """What is wrong with a file, beside what the manifest states of it."""
    mesh = trimesh.load(path, process=True, validate=False)
    faults = []
    edges = mesh.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2).astype(np.int64)
    count = len(mesh.vertices)
    forth, back = edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]
    if not mesh.is_watertight or not mesh.is_winding_consistent or len(np.unique(forth)) != len(forth):
        faults.append("edges that are not used once in each direction")
    elif not np.array_equal(np.sort(forth), np.sort(back)):
        faults.append("edges without a neighbour")
    if not mesh.area_faces.min() > 0:
        faults.append("a triangle without area")
    if len(mesh.faces) != stated["triangles"]:
        faults.append(f"{len(mesh.faces)} triangles, stated {stated['triangles']}")
    shells = trimesh.graph.connected_component_labels(mesh.face_adjacency, len(mesh.faces))
    volumes = np.bincount(shells, signed_volumes(mesh))
    if not mesh.volume > 0:
        faults.append(f"volume {mesh.volume}: wound inwards")
    # chi = 2 shells - 2 genus, summed over all shells.
    genus = len(volumes) - mesh.euler_number // 2
    if genus != stated["genus"]:
        faults.append(f"genus {genus}, stated {stated['genus']}")
    return faults, len(volumes), int((volumes < 0).sum())


def signed_volumes(mesh):
    corners = mesh.triangles - mesh.bounds.mean(axis=0)
    return np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6


def judge_files(folder, usual_shells):
    """Faults of all files of an export, and how many there are."""
    manifest = json.loads((folder / "manifest.json").read_text())
    faults, files = [], 0
    for part in manifest["parts"]:
        path = folder / f"{part['name']}.stl"
        if not path.exists():
            faults.append(f"{part['name']}: no file")
            continue
        files += 1
        found, shells, voids = faults_of_mesh(path, part["mesh"])
        # What a manifest does not state is judged by the unchanged design, where that is one piece.
        expected = part["mesh"].get("shells", 1 if usual_shells.get(part["name"]) == 1 else None)
        if expected is not None and shells != expected:
            found.append(f"{shells} shells ({voids} of them enclosed), expected {expected}")
        faults += [f"{part['name']}: {fault}" for fault in found]
    return faults, files


def judge(work, name, settings, arguments):
    """Outcome, what is wrong, files checked, the refusal's document."""
    folder = work["folder"] / "variant"
    code, document = export(work["binary"], folder, name, settings, arguments)
    if code not in ALLOWED_EXITS:
        return "failed", [f"exit {code}: {brief(document)}"], 0, document
    if code != 0:
        return ALLOWED_EXITS[code], [], 0, document
    faults, files = judge_files(folder, usual_shells(work, name))
    return ("failed" if faults else "made"), faults, files, None


def brief(document):
    if isinstance(document, dict):
        return "; ".join(problem["message"] for problem in document.get("problems", []))[:300]
    lines = [line for line in document.splitlines() if line.strip()]
    return (lines[0] if lines else "nothing said")[:300]


def usual_shells(work, name):
    """Shells of every body of the unchanged design."""
    known = work["shells"]
    if name not in known:
        folder = work["folder"] / "usual"
        sensor_bodies = [body for n, _, bodies in work["targets"] if n == name for body in bodies]
        known[name] = {}
        parts = [[], [word for body in sensor_bodies for word in ("--part", body)]]
        if name.endswith("/semi-domes"):
            parts = [["--part", "holder", "--part", "semi-dome-000"]]
        for words in parts if sensor_bodies and "/" not in name else parts[:1]:
            code, _ = export(work["binary"], folder, name, {}, ["--format", "stl", "--tolerance", "0.05mm", *words])
            if code == 0:
                for part in json.loads((folder / "manifest.json").read_text())["parts"]:
                    found = faults_of_mesh(folder / f"{part['name']}.stl", part["mesh"])
                    known[name][part["name"]] = found[1]
    return known[name]


def smallest(work, name, settings, arguments):
    """The same fault with fewer settings: each that is not needed is left out."""
    settings = dict(settings)
    for path in list(settings):
        fewer = {p: v for p, v in settings.items() if p != path}
        if judge(work, name, fewer, arguments)[0] == "failed":
            settings = fewer
    return settings


def one(index):
    work = WORK
    name, settings, arguments = variant(work["targets"], work["seed"], index)
    files = tried = 0
    deaf = []
    for _ in range(REPAIRS + 1):
        outcome, faults, checked, document = judge(work, name, settings, arguments)
        files, tried = files + checked, tried + 1
        better, said = advice(document, settings) if outcome == "refused" else ({}, {})
        # A single piece of advice is followed alone, so that it must help.
        if not better or tried > REPAIRS:
            break
        path = next(iter(better))
        settings = {**settings, path: better[path]}
        if len(document["problems"]) == 1:
            again = fabkit_refusal(work, name, settings, arguments)
            if again.get(path) == said[path]:
                deaf.append((settings, f"{path}={better[path]} is recommended, and refused"))
    result = {"name": name, "outcome": outcome, "files": files, "faults": []}
    if outcome == "failed":
        settings = smallest(work, name, settings, arguments)
        _, least, _, _ = judge(work, name, settings, arguments)
        result["faults"].append((command(name, settings, arguments), least or faults))
    for with_advice, fault in deaf:
        result["outcome"] = "failed"
        result["faults"].append((command(name, with_advice, arguments), [fault]))
    return result


def fabkit_refusal(work, name, settings, arguments):
    """What is said of each path by the refusal of a variant."""
    _, document = export(work["binary"], work["folder"] / "variant", name, settings, arguments)
    return advice(document, settings)[1]


WORK = {}


def start(binary, seed, found, folder):
    own = Path(folder) / f"worker-{os.getpid()}"
    own.mkdir()
    WORK.update(binary=binary, seed=seed, targets=found, folder=own, shells={})


def main(binary, count, seed):
    begun = time.monotonic()
    found = targets(binary)
    table, files, faults = {}, 0, []
    workers = min(2, os.cpu_count() or 1)
    with tempfile.TemporaryDirectory(prefix="fabkit-variants-") as folder:
        with multiprocessing.Pool(workers, start, (binary, seed, found, folder)) as pool:
            for index, result in enumerate(pool.imap(one, range(count), chunksize=4)):
                table.setdefault(result["name"], Counter())[result["outcome"]] += 1
                table[result["name"]]["files"] += result["files"]
                files += result["files"]
                for line, what in result["faults"]:
                    faults.append(line)
                    print(f"\nfault of variant {index}: {'; '.join(what)}\n  {line}", flush=True)
    print(f"\n{'':32}{'made':>8}{'refused':>9}{'too large':>11}{'failed':>8}{'files':>8}")
    for name, row in sorted(table.items()):
        cells = (row["made"], row["refused"], row["too large"], row["failed"], row["files"])
        print(f"{name:32}{cells[0]:8}{cells[1]:9}{cells[2]:11}{cells[3]:8}{cells[4]:8}")
    total = sum(table.values(), Counter())
    print(
        f"{count} variants (seed {seed}) in {time.monotonic() - begun:.0f} s: {total['made']} made, "
        f"{total['refused']} refused, {total['too large']} too large, {total['failed']} failed; "
        f"{files} files checked"
    )
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
