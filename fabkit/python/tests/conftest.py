"""Shared fixtures, and the choice of a sample of tests that differ little."""

import json
import os
import subprocess
import sys

import pytest

# Modules whose tests repeat with the package what is tested with the command or in another process.
# Every third of their tests is run, and all of them with FABKIT_FULL=1.
SAMPLED = {
    "test_capture",
    "test_dataset",
    "test_errors",
    "test_fork",
    "test_same_bytes",
    "test_sim",
    "test_sweep",
    "test_sweep_dask",
    "test_words",
}
EVERY = 3


def pytest_collection_modifyitems(config, items):
    """Skip the tests that are not in the sample."""
    if os.environ.get("FABKIT_FULL") == "1":
        return
    sampled = [item for item in items if item.path.stem in SAMPLED]
    left_out = {id(item) for number, item in enumerate(sampled) if number % EVERY}
    config.hook.pytest_deselected(items=[item for item in items if id(item) in left_out])
    items[:] = [item for item in items if id(item) not in left_out]


@pytest.fixture(scope="session")
def command():
    """Return a function that runs the package's command.

    It returns the output, or with ``check=False`` the completed process.
    """

    def run(*arguments, check=True):
        line = [sys.executable, "-m", "fabkit", *map(str, arguments)]
        done = subprocess.run(line, capture_output=True, text=True, check=False)
        if not check:
            return done
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout) if "--json" in arguments else done.stdout

    return run


@pytest.fixture(scope="session")
def rtac0():
    """Load the sensor once for all tests."""
    import fabkit

    return fabkit.load("rtac0")
