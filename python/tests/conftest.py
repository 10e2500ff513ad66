"""What several tests use."""

import json
import subprocess
import sys

import pytest


@pytest.fixture(scope="session")
def command():
    """Run the package's command; its output, or with ``check=False`` the process."""

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
    """Load a sensor once."""
    import fabkit

    return fabkit.load("rtac0")
