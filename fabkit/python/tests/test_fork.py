"""A forked child uses the package after its parent has: every way to fork, every kind of work."""

import os
import subprocess
import sys
import textwrap

import pytest

# Work that runs on several threads, done in the parent, then in children, with the same result.
WORK = {
    "press": """
        sensor = sim.Sensor("digit-like", size_px=(32, 24), spacing_mm=1.5)

        def work(_=None):
            return sensor.press("ball@0mm,0mm,0.3mm", seed=None).force_n.tolist()
    """,
    "check": """
        sensor = fabkit.load("digit-like")

        def work(_=None):
            return len(sensor.check().findings)
    """,
    "mesh": """
        sensor = fabkit.load("digit-like")

        def work(_=None):
            return [len(sensor.parts[name].mesh(0.1).vertices) for name in list(sensor.parts)[:3]]
    """,
    "truth": """
        scene = fabkit.depth.Scene("rtac0").resized(64, 48)

        def work(_=None):
            # Pixels beside the surface are NaN, which equals nothing.
            return float(np.nanmax(scene.cast("ball@0deg,0deg,0.5mm").indentation_mm))
    """,
    "command": """
        def work(_=None):
            return _fabkit.command(["fabkit", "--threads", "2", "--quiet", "check", "digit-like"])
    """,
}

# Ways to fork: each prints `True` if all children return what the parent did.
FORK = {
    "os.fork": """
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.write(writing, repr(work()).encode())
            os._exit(0)
        os.waitpid(child, 0)
        print(os.read(reading, 10000).decode() == repr(before))
    """,
    "grandchild": """
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            same = work() == before
            grandchild = os.fork()
            if grandchild == 0:
                os.write(writing, repr(same and work() == before).encode())
                os._exit(0)
            os.waitpid(grandchild, 0)
            os._exit(0)
        os.waitpid(child, 0)
        print(os.read(reading, 100).decode())
    """,
    "Pool": """
        with multiprocessing.get_context("fork").Pool(2) as pool:
            print(pool.map(work, range(3)) == [before] * 3)
    """,
    "futures": """
        context = multiprocessing.get_context("fork")
        with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
            print(list(pool.map(work, range(3))) == [before] * 3)
    """,
}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork")
@pytest.mark.parametrize("way", FORK)
@pytest.mark.parametrize("kind", WORK)
def test_a_forked_child_works_as_its_parent(kind, way):
    program = "\n".join(
        [
            "import concurrent.futures, multiprocessing, os",
            "import fabkit, fabkit.depth, fabkit.sim as sim, numpy as np",
            "from fabkit import _fabkit",
            textwrap.dedent(WORK[kind]),
            "before = work()",
            textwrap.dedent(FORK[way]),
        ]
    )
    # The longest takes a few seconds; a child that waits for threads of its parent waits for ever.
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "True", done.stdout
