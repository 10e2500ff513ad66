"""What a cast costs from Python beside Rust: ``python overhead.py PATH/TO/examples/cast_time``.

Both cast the same press of the R-Tac0 at 640 x 480 into the same arrays, in turns, so that what
else the machine does falls on both. Processor time, of all threads, is what does not depend on
that; what a process costs besides its casts is taken off by the difference of two counts.
"""

import resource
import statistics
import subprocess
import sys
import time

import fabkit

PRESS = "semi-dome-017"
ROUNDS = 5
FEW, MANY = 2, 22


def of_children():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def from_rust(example, count):
    """Wall times, ms, and processor time of the whole process, s."""
    before = of_children()
    line = [example, PRESS, str(count)]
    text = subprocess.run(line, check=True, capture_output=True, text=True).stdout
    return [float(word) for word in text.split()], of_children() - before


def from_python(scene, count):
    """Wall times, ms, and processor time, s."""
    before, walls_ms = time.process_time(), []
    for _ in range(count):
        start = time.perf_counter()
        scene.cast(PRESS)
        walls_ms.append(1e3 * (time.perf_counter() - start))
    return walls_ms, time.process_time() - before


def main():
    scene = fabkit.depth.Scene("rtac0")
    from_python(scene, FEW)
    walls_ms = {"Rust": [], "Python": []}
    cpu_ms = {"Rust": [], "Python": []}
    for _ in range(ROUNDS):
        _, few = from_rust(sys.argv[1], FEW)
        walls, many = from_rust(sys.argv[1], MANY)
        walls_ms["Rust"] += walls
        cpu_ms["Rust"].append(1e3 * (many - few) / (MANY - FEW))
        walls, seconds = from_python(scene, MANY)
        walls_ms["Python"] += walls
        cpu_ms["Python"].append(1e3 * seconds / MANY)
    for what, times in (("wall", walls_ms), ("CPU", cpu_ms)):
        rust, python = (statistics.median(times[name]) for name in ("Rust", "Python"))
        print(f"{what:<5} Rust {rust:7.2f} ms, Python {python:7.2f} ms, ratio {python / rust:.3f}")


if __name__ == "__main__":
    main()
