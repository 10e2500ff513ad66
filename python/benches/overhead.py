"""What a cast costs from Python beside Rust: ``python overhead.py PATH/TO/examples/cast_time``.

Both cast the same press of the R-Tac0 at 640 x 480 into the same arrays, in turns, so that what
else the machine does falls on both.
"""

import statistics
import subprocess
import sys
import time

import fabkit

PRESS = "semi-dome-017"
ROUNDS = 10
CASTS = 10


def from_rust(example):
    text = subprocess.run([example, PRESS, str(CASTS)], check=True, capture_output=True, text=True)
    return [float(line) for line in text.stdout.split()]


def from_python(scene):
    times_ms = []
    for _ in range(CASTS):
        start = time.perf_counter()
        scene.cast(PRESS)
        times_ms.append(1e3 * (time.perf_counter() - start))
    return times_ms


def main():
    scene = fabkit.depth.Scene("rtac0")
    rust, python = [], []
    for _ in range(ROUNDS):
        rust += from_rust(sys.argv[1])
        python += from_python(scene)
    for name, times_ms in (("Rust", rust), ("Python", python)):
        best, median = min(times_ms), statistics.median(times_ms)
        print(f"{name:<7} best {best:7.2f} ms, median {median:7.2f} ms of {len(times_ms)}")
    print(f"ratio   best {min(python) / min(rust):.3f}, ", end="")
    print(f"median {statistics.median(python) / statistics.median(rust):.3f}")


if __name__ == "__main__":
    main()
