"""Times fabkit beside its peers and writes the table of docs/benchmarks.md.

`cargo xtask bench-peers` calls it. Every build is a fresh process; kernels take turns, so that a busy
machine is as busy for one as for the other. Needs numpy, and for the peers what `fabkit_verify` needs.
"""

import argparse
import json
import os
import resource
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy

TOLERANCE_MM = 0.01
PEERS = ("manifold3d", "cadquery", "build123d")
RUNS = {"fabkit": 5, "manifold3d": 5, "cadquery": 1, "build123d": 1}
# What one build may take, CPU s. Without a limit, a boolean of hundreds of tools may never end.
LIMIT_CPU_S = 60
START, END = "<!-- bench-peers -->\n", "<!-- end -->\n"


@dataclass
class Run:
    """One process."""

    cpu_s: float
    process_cpu_s: float
    wall_s: float
    rss_mib: float
    exact_mm3: float | None


@dataclass
class Result:
    """One part in one kernel."""

    cpu_s: float
    process_cpu_s: float
    wall_s: float
    rss_mib: float
    triangles: int = 0
    volume_mm3: float = 0.0
    lowest_mm: float = 0.0
    exact_mm3: float | None = None


@dataclass
class Part:
    """A tree, and what each kernel made of it."""

    tree: Path
    results: dict[str, Result] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)

    @property
    def name(self):
        return self.tree.name.removesuffix(".tree.json")


def limit_cpu():
    """In the child."""
    resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_CPU_S, LIMIT_CPU_S + 5))


def spawn(command):
    """Runs a process and asks the system what it used."""
    start = time.perf_counter()
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as complained:
        process = subprocess.Popen(
            command, stdout=said, stderr=complained, preexec_fn=limit_cpu
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        wall_s = time.perf_counter() - start
        said.seek(0)
        complained.seek(0)
        if process.returncode == -signal.SIGXCPU:
            raise RuntimeError(f"stopped after {LIMIT_CPU_S} s")
        if process.returncode != 0:
            words = complained.read().decode(errors="replace").strip().splitlines()
            raise RuntimeError(words[-1] if words else f"ended by signal {-process.returncode}")
        answer = said.read()
    cpu_s = usage.ru_utime + usage.ru_stime
    of_work = json.loads(answer) if answer.strip() else {}
    # Without imports and reading the tree, where the process says so itself.
    own_s = of_work.get("cpu_s", cpu_s)
    return Run(own_s, cpu_s, wall_s, usage.ru_maxrss / 1024, of_work.get("exact_mm3"))


def read_stl(path):
    """Corners, n x 3 x 3."""
    content = path.read_bytes()
    (count,) = struct.unpack_from("<I", content, 80)
    record = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    return numpy.frombuffer(content, record, count, 84)["corners"].astype(float)


def measure(corners):
    """Volume and the smallest altitude of a triangle over its longest edge."""
    a, b, c = (corners[:, i] - corners[0, 0] for i in range(3))
    normal = numpy.cross(b - a, c - a)
    volume = numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6.0
    longest = numpy.max([numpy.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
    altitudes = numpy.linalg.norm(normal, axis=1) / numpy.maximum(longest, 1e-300)
    return float(volume), float(altitudes.min())


def build(part, kernels, commands, folder):
    """All kernels in turn, as often as each runs."""
    runs = {kernel: [] for kernel in kernels}
    for turn in range(max(RUNS.values())):
        for kernel in kernels:
            if turn >= RUNS[kernel] or kernel in part.failures:
                continue
            stl = folder / f"{kernel}.stl"
            try:
                runs[kernel].append(spawn(commands[kernel](part.tree, stl)))
            except RuntimeError as error:
                part.failures[kernel] = str(error)
    for kernel in kernels:
        if kernel in part.failures:
            continue
        middle = {
            name: statistics.median(getattr(run, name) for run in runs[kernel])
            for name in ("cpu_s", "process_cpu_s", "wall_s", "rss_mib")
        }
        corners = read_stl(folder / f"{kernel}.stl")
        volume_mm3, lowest_mm = measure(corners)
        exact_mm3 = runs[kernel][0].exact_mm3
        part.results[kernel] = Result(
            **middle,
            triangles=len(corners),
            volume_mm3=volume_mm3,
            lowest_mm=lowest_mm,
            exact_mm3=exact_mm3,
        )
    print(f"{part.name}: " + ", ".join(in_words(part, k) for k in kernels), flush=True)


def in_words(part, kernel):
    """For whoever waits."""
    if kernel in part.failures:
        return f"{kernel} {part.failures[kernel]}"
    return f"{kernel} {part.results[kernel].cpu_s:.3f} s"


def exact_mm3(part):
    """In closed form where the document says so, otherwise by an exact kernel's integration."""
    stated = json.loads(part.tree.read_text(encoding="utf-8")).get("exact_mm3")
    integrated = (part.results[k].exact_mm3 for k in PEERS if k in part.results)
    return stated or next((value for value in integrated if value), None)


def rows(title, parts, kernels):
    """One row per kernel: sums over the parts, the largest memory, the worst of the rest."""
    # Ratios compare what both have done.
    lines = []
    for kernel in kernels:
        done = [p for p in parts if kernel in p.results and "fabkit" in p.results]
        if not done:
            reason = next((p.failures[kernel] for p in parts if kernel in p.failures), "failed")
            lines.append(f"| {title} | {kernel} | {reason} |  |  |  |  |  |  |  |")
            continue
        results = [p.results[kernel] for p in done]
        total = {n: sum(getattr(r, n) for r in results) for n in ("cpu_s", "process_cpu_s", "wall_s")}
        ours = sum(p.results["fabkit"].cpu_s for p in done)
        errors = [
            r.volume_mm3 / exact - 1.0
            for p, r in zip(done, results)
            if (exact := exact_mm3(p)) is not None
        ]
        error = f"{max(errors, key=abs):+.1e}" if errors else ""
        name = kernel if len(done) == len(parts) else f"{kernel} ({len(done)} of {len(parts)})"
        lines.append(
            f"| {title} | {name} | {total['cpu_s']:.3f} | {total['process_cpu_s']:.3f} "
            f"| {total['wall_s']:.3f} | {max(r.rss_mib for r in results):.0f} "
            f"| {sum(r.triangles for r in results)} | {error} "
            f"| {1e3 * min(r.lowest_mm for r in results):.2g} | {ours / total['cpu_s']:.3f} |"
        )
        title = ""
    return lines


def table(groups, kernels):
    """Markdown."""
    lines = [
        "| part | kernel | CPU s | of the process | wall s | peak MiB | triangles | volume error "
        "| lowest altitude, µm | fabkit : it |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for title, parts in groups:
        lines += rows(title, parts, kernels)
    return "\n".join(lines) + "\n"


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--fabkit", required=True, help="the example `peer`")
    arguments.add_argument("--verify", help="folder of the package fabkit_verify; no peers without")
    arguments.add_argument("--write", type=Path, help="document whose table is replaced")
    arguments.add_argument("groups", nargs="+", help="TITLE=TREE,TREE,...")
    given = arguments.parse_args()

    here = Path(__file__).parent
    kernels = ["fabkit", *(PEERS if given.verify else ())]
    if given.verify:
        os.environ["PYTHONPATH"] = given.verify

    def peer(kernel):
        script = [sys.executable, str(here / "build.py"), kernel]
        return lambda tree, stl: [*script, str(tree), str(TOLERANCE_MM), str(stl)]

    commands = {kernel: peer(kernel) for kernel in PEERS}
    commands["fabkit"] = lambda tree, stl: [
        given.fabkit, "mesh", str(tree), str(TOLERANCE_MM), str(stl)
    ]
    groups = []
    with tempfile.TemporaryDirectory() as folder:
        for group in given.groups:
            title, trees = group.split("=", 1)
            parts = [Part(Path(tree)) for tree in trees.split(",")]
            for part in parts:
                build(part, kernels, commands, Path(folder))
            groups.append((title, parts))
    made = table(groups, kernels)
    print(made)
    if given.write:
        text = given.write.read_text(encoding="utf-8")
        before, rest = text.split(START, 1)
        after = rest.split(END, 1)[1]
        given.write.write_text(before + START + made + END + after, encoding="utf-8")


if __name__ == "__main__":
    main()
